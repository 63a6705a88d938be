#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "CaseIO/TransformFile.h"
#include "Core/Errors.h"
#include "Core/Types.h"
#include "TemporaryFolder.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;
using testing::MessageOf;
using testing::TemporaryFolder;

TEST(TransformFile, AMatrixIsTakenAsItStands) {
  TemporaryFolder folder;
  const auto t = ReadTransformFile(folder.Write("t.txt", "0 -1 0 5\n1 0 0 6\n0 0 1 7\n0 0 0 1\n"));
  EXPECT_LT((t * Vec3(1, 2, 3) - Vec3(3, 7, 10)).norm(), 1e-12);
}

TEST(TransformFile, AnItkTransformIsStoredFromParent) {
  TemporaryFolder folder;
  const auto t = ReadTransformFile(folder.Write(
      "t.tfm",
      "#Insight Transform File V1.0\n#Transform 0\nTransform: AffineTransform_double_3_3\n"
      "Parameters: 0 -1 0 1 0 0 0 0 1 5 6 7\nFixedParameters: 1 1 0\n"));
  // The file maps y to A(y − c) + c + t; the transform is its inverse.
  const Vec3 y(1, 2, 3), c(1, 1, 0);
  Eigen::Matrix3d a;
  a << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Vec3 x = a * (y - c) + c + Vec3(5, 6, 7);
  EXPECT_LT((t * x - y).norm(), 1e-12);
}

TEST(TransformFile, NamesWhatIsWrong) {
  TemporaryFolder folder;
  auto message = [&](const std::string& text) {
    return MessageOf<InputError>([&] { ReadTransformFile(folder.Write("t.tfm", text)); });
  };
  EXPECT_THAT(message("1 0 0"), HasSubstr("3 numbers"));
  EXPECT_THAT(message("1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1"), HasSubstr("last row"));
  EXPECT_THAT(message("0 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"), HasSubstr("inverted"));
  EXPECT_THAT(message("1 x"), HasSubstr("\"x\""));
  EXPECT_THAT(message("\x89HDF\r\n"), HasSubstr("HDF5"));
  EXPECT_THAT(message("#Insight Transform File V1.0\nTransform: BSplineTransform_double_3_3\n"),
              HasSubstr("BSpline"));
}

}  // namespace
}  // namespace kerf
