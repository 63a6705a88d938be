// A network stream at the desk: pictures come, a silent or lost one is said and taken up again.
#include <gtest/gtest.h>

#include "DeskScene.h"
#include "MjpegServer.h"
#include "Support/HeldClock.h"

namespace kerf {
namespace {

using namespace testing;
using Kind = SourceState::Kind;

Image Grey(int n) {
  Image image;
  image.width = 320;
  image.height = 240;
  image.channels = 3;
  image.data.assign(std::size_t(3) * 320 * 240, std::uint8_t(40 + 8 * (n % 20)));
  return image;
}

struct StreamedDesk {
  StreamedDesk() {
    CaptureOptions options;
    options.clock = clock;
    desk.SetCaptureOptions(options);
    desk.OpenSource(camera.Url());
    EXPECT_TRUE(Within(20, [&] { return Is(Kind::Running) && desk.Newest(); }));
  }
  bool Is(Kind kind) const { return desk.Source().kind == kind; }
  int Delivered() const { return desk.Source().delivered; }
  MjpegServer camera{Grey};
  HeldClock clock;
  IntraoperativeDesk desk;
};

TEST(Stream, PicturesComeAndOnlyTheNewestIsKept) {
  StreamedDesk stream;
  const SourceState source = stream.desk.Source();
  EXPECT_EQ(source.width, 320);
  EXPECT_EQ(source.height, 240);
  const int first = stream.Delivered();
  ASSERT_TRUE(Within(10, [&] { return stream.Delivered() > first + 10; }));
  // Nobody took any: none waits in a queue.
  EXPECT_GE(stream.desk.Source().dropped, 10);
  EXPECT_GE(stream.desk.Newest()->frame.index, first + 10);
}

TEST(Stream, ASilentCameraIsSaidAndItsPicturesAreTakenUpAgain) {
  StreamedDesk stream;
  const auto source = [&] { return stream.desk.Source(); };
  stream.camera.SetSilent(true);
  ASSERT_TRUE(Within(10, [&] { return source().silence_s > 0.2; }));  // nothing is on its way
  stream.clock.HoldSince(source, 0.3);
  EXPECT_TRUE(stream.Is(Kind::Running));
  stream.clock.HoldSince(source, 0.5);
  const SourceState frozen = source();
  EXPECT_EQ(frozen.kind, Kind::Frozen);
  EXPECT_FALSE(frozen.Usable());
  EXPECT_NE(frozen.message.find("frozen"), std::string::npos);
  stream.clock.GoOn();
  stream.camera.SetSilent(false);
  ASSERT_TRUE(Within(10, [&] { return stream.Is(Kind::Running); }));
  EXPECT_TRUE(stream.desk.Source().message.empty());
}

TEST(Stream, ACameraThatStaysSilentIsConnectedAnew) {
  StreamedDesk stream;
  stream.camera.SetSilent(true);
  ASSERT_TRUE(Within(15, [&] { return stream.Is(Kind::Lost); }));
  stream.camera.SetSilent(false);
  ASSERT_TRUE(Within(20, [&] { return stream.Is(Kind::Running); }));
  EXPECT_GE(stream.desk.Source().reconnects, 1);
  EXPECT_GE(stream.camera.Connections(), 2);
}

TEST(Stream, ALostConnectionIsSaidAndOpenedAgain) {
  StreamedDesk stream;
  const int before = stream.desk.Newest()->frame.index;
  stream.camera.Close();
  ASSERT_TRUE(Within(10, [&] { return stream.Is(Kind::Lost); }));
  EXPECT_NE(stream.desk.Source().message.find("Trying again"), std::string::npos);
  stream.camera.Open();
  ASSERT_TRUE(Within(20, [&] { return stream.Is(Kind::Running); }));
  EXPECT_EQ(stream.desk.Source().reconnects, 1);
  ASSERT_TRUE(Within(10, [&] { return stream.desk.Newest()->frame.index > before; }));
}

TEST(Stream, NobodyAtTheAddressIsASentence) {
  MjpegServer camera(Grey);
  camera.Close();
  IntraoperativeDesk desk;
  desk.OpenSource(camera.Url());
  ASSERT_TRUE(Within(20, [&] { return desk.Source().kind == Kind::Lost; }));
  EXPECT_NE(desk.Source().message.find("cannot be opened"), std::string::npos);
}

}  // namespace
}  // namespace kerf
