// What the list of series tells a person: phase of contrast, side, patient.
#include <gtest/gtest.h>

#include "Adapters/Itk/DicomPhase.h"

namespace kerf {
namespace {

TEST(DicomPhase, IsReadFromTheNamesThatScannersGive) {
  const std::pair<const char*, const char*> names[] = {
      {"Abdomen portalvenoes 2.0 B30f", "portal venous"},
      {"ABD ART 1.0", ""},  // could be anything
      {"Leber arteriell 1.5", "arterial"},
      {"Late arterial", "arterial"},
      {"VENOUS PHASE", "venous"},
      {"Nephrographic", "nephrographic"},
      {"ABD nativ", "native"},
      {"Abdomen without contrast", "native"},
      {"delayed 5 min", "delayed"},
      {"Temps tardif", "delayed"},
      {"Abdomen 1.0", ""}};
  for (const auto& [description, phase] : names)
    EXPECT_EQ(ContrastPhase({description, "", "", ""}), phase) << description;
}

TEST(DicomPhase, TheAgentAndItsTimeCount) {
  EXPECT_EQ(ContrastPhase({"Abdomen", "Iomeprol", "", ""}), "contrast");
  EXPECT_EQ(ContrastPhase({"Abdomen", "Iomeprol", "101500", "101610.4"}), "contrast, 70 s");
  EXPECT_EQ(ContrastPhase({"venous", "", "095930", "100040"}), "venous, 70 s");
  // Another day, another scan, no time: none is said.
  EXPECT_EQ(ContrastPhase({"venous", "", "101500", "101400"}), "venous");
  EXPECT_EQ(ContrastPhase({"venous", "", "081500", "101400"}), "venous");
  EXPECT_EQ(ContrastPhase({"venous", "", "soon", "101400"}), "venous");
  EXPECT_EQ(ContrastPhase({"nativ", "", "101500", "101610"}), "native");
}

TEST(DicomPhase, SideAndNameInWords) {
  EXPECT_EQ(LateralityInWords("L"), "left");
  EXPECT_EQ(LateralityInWords("R"), "right");
  EXPECT_EQ(LateralityInWords("U"), "");
  EXPECT_EQ(PersonName("Doe^Jane^^^"), "Doe, Jane");
  EXPECT_EQ(PersonName("Doe^Jane^Maria^Dr"), "Doe, Jane Maria");
  EXPECT_EQ(PersonName("Yamada^Tarou=\xe5\xb1\xb1\xe7\x94\xb0"), "Yamada, Tarou");
  EXPECT_EQ(PersonName("Doe"), "Doe");
  EXPECT_EQ(PersonName(""), "");
}

}  // namespace
}  // namespace kerf
