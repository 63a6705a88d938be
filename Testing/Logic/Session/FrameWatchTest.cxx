// What the time stamps of the registered pictures say: too few of them, and cuts may be missed.
#include <gtest/gtest.h>

#include "Session/FrameWatch.h"

namespace kerf {
namespace {

Reliability Good() {
  Reliability good;
  good.state = GateState::Green;
  good.score = 0.9;
  good.reason = "ok";
  return good;
}

/// Pictures at a steady rate from `from_s` on. @return what the last of them was judged
Reliability Steady(double per_second, int pictures, FrameWatch* watch, double from_s = 0.0) {
  Reliability last;
  for (int i = 0; i < pictures; ++i) {
    last = Good();
    watch->WatchRate(from_s + i / per_second, &last);
  }
  return last;
}

TEST(FrameWatch, FewPicturesASecondAreAmberAndSayHowMany) {
  const struct {
    double rate;
    const char* reason;
  } cases[] = {{2.9, "2 pictures a second registered: cuts may be missed"},
               {2.6, "2 pictures a second registered: cuts may be missed"},
               {2.0, "2 pictures a second registered: cuts may be missed"},
               {1.0, "1 picture a second registered: cuts may be missed"},
               {0.3, "less than 1 picture a second registered: cuts may be missed"}};
  for (const auto& c : cases) {
    FrameWatch watch;
    const Reliability last = Steady(c.rate, 8, &watch);
    EXPECT_EQ(last.state, GateState::Amber) << c.rate;
    EXPECT_EQ(last.reason, c.reason);
    EXPECT_LT(last.score, 0.5);
  }
}

TEST(FrameWatch, EnoughPicturesStayGreen) {
  for (const double rate : {3.2, 5.0, 25.0, 60.0}) {
    FrameWatch watch;
    EXPECT_EQ(Steady(rate, 50, &watch).state, GateState::Green) << rate;
  }
}

TEST(FrameWatch, TheFirstPicturesAndOneThatIsLateAreNoRate) {
  FrameWatch watch;
  EXPECT_EQ(Steady(1.0, 3, &watch).state, GateState::Green);
  FrameWatch late;
  Steady(25.0, 50, &late);                                           // to 1.96 s
  EXPECT_EQ(Steady(25.0, 50, &late, 2.5).state, GateState::Green);   // after 0.54 s
  EXPECT_EQ(Steady(25.0, 2, &late, 6.0).state, GateState::Amber);    // after 1.54 s
  EXPECT_EQ(Steady(25.0, 20, &late, 6.08).state, GateState::Amber);  // for a second
  EXPECT_EQ(Steady(25.0, 20, &late, 6.88).state, GateState::Green);
}

TEST(FrameWatch, APictureThatIsRegisteredAgainIsNoPause) {
  FrameWatch watch;
  Steady(25.0, 50, &watch);
  for (int i = 0; i < 5; ++i) {
    Reliability again = Good();
    watch.WatchRate(1.96, &again);
    EXPECT_EQ(again.state, GateState::Green);
  }
}

TEST(FrameWatch, AGateThatIsOffStaysOffForItsOwnReason) {
  FrameWatch watch;
  Steady(1.0, 8, &watch);
  Reliability off = Good();
  off.state = GateState::Off;
  off.reason = "no feature is tracked";
  watch.WatchRate(8.0, &off);
  EXPECT_EQ(off.state, GateState::Off);
  EXPECT_EQ(off.reason, "no feature is tracked");
}

TEST(FrameWatch, FewPicturesDoNotHideWhatElseIsWrong) {
  FrameWatch watch;
  Steady(1.0, 8, &watch);
  Reliability outline = Good();
  outline.state = GateState::Amber;
  outline.score = 0.45;
  outline.reason = "the outline does not fit the image";
  watch.WatchRate(8.0, &outline);
  EXPECT_EQ(outline.state, GateState::Amber);
  EXPECT_EQ(outline.reason, "the outline does not fit the image");
  EXPECT_LT(outline.score, 0.45);
  Reliability leapt = Good();
  watch.WatchLeap(8.0, 0.0, &leapt);
  watch.WatchLeap(8.04, 20.0, &leapt);
  watch.WatchRate(8.04, &leapt);
  EXPECT_EQ(leapt.reason, "everything leapt: has the camera moved?");
}

}  // namespace
}  // namespace kerf
