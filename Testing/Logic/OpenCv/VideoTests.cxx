#include <gtest/gtest.h>
#include <malloc.h>
#include <sched.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "Adapters/Ffmpeg/VideoWriter.h"
#include "Adapters/OpenCv/EncodedSize.h"
#include "Adapters/OpenCv/ImageSequence.h"
#include "Adapters/OpenCv/VideoSource.h"
#include "Core/Errors.h"
#include "SyntheticVideo.h"

namespace fs = std::filesystem;
using namespace kerf;
using kerf::test::Scratch;
using kerf::test::Tissue;

namespace {

/// The number of the frame as a bright bar, so that a frame can be told after compression.
cv::Mat Numbered(int width, int height, int number) {
  cv::Mat image = Tissue(width, height, 3);
  cv::rectangle(image, cv::Rect(0, 0, 4 * (number + 1), 16), cv::Scalar(255, 255, 255), cv::FILLED);
  return image;
}
int NumberOf(const Image& image) {
  const cv::Mat bar = ViewOf(image).row(6);
  int bright = 0;
  for (int x = 0; x < bar.cols; ++x) bright += bar.at<cv::Vec3b>(0, x)[0] > 180 ? 1 : 0;
  return static_cast<int>(std::lround(bright / 4.0)) - 1;
}

void WriteVideo(const std::string& path, int frames, int width = 160, int height = 120) {
  VideoWriter writer(path, width, height, 25);
  for (int i = 0; i < frames; ++i) writer.Write(ToImage(Numbered(width, height, i)));
  writer.Finish();
}

std::string Slurp(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
void Spill(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string MessageOf(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Video, WrittenFramesComeBackInOrder) {
  Scratch folder("video");
  WriteVideo(folder / "v.mp4", 30);
  EXPECT_FALSE(fs::exists(folder / "v.part.mp4"));
  const auto source = OpenVideo(folder / "v.mp4");
  EXPECT_EQ(source->Width(), 160);
  EXPECT_EQ(source->Height(), 120);
  EXPECT_EQ(source->FrameCount(), 30);
  EXPECT_NEAR(source->FramesPerSecond(), 25, 1e-6);
  int expected = 0;
  while (const auto frame = source->Next()) {
    EXPECT_EQ(frame->index, expected);
    EXPECT_NEAR(frame->time_s, expected / 25.0, 1e-9);
    EXPECT_EQ(NumberOf(*frame->image), expected);
    ++expected;
  }
  EXPECT_EQ(expected, 30);
  EXPECT_FALSE(source->Broken()) << source->BreakReport();
}

TEST(Video, WritesH264In420) {
  Scratch folder("codec");
  WriteVideo(folder / "v.mp4", 3);
  cv::VideoCapture capture(folder / "v.mp4", cv::CAP_FFMPEG);
  const int fourcc = static_cast<int>(capture.get(cv::CAP_PROP_FOURCC));
  EXPECT_EQ(fourcc, cv::VideoWriter::fourcc('a', 'v', 'c', '1'));
  const int format = static_cast<int>(capture.get(cv::CAP_PROP_CODEC_PIXEL_FORMAT));
  EXPECT_EQ(format, cv::VideoWriter::fourcc('I', '4', '2', '0'));
}

TEST(Video, WritingIsDeterministicWhateverIsInMemoryAndOnOneCore) {
  Scratch folder("written-twice");
  // What malloc returns and what free leaves is filled with another byte each time.
  for (const int fill : {0, 1, 85, 254}) {
    mallopt(M_PERTURB, fill);
    WriteVideo(folder / ("v" + std::to_string(fill) + ".mp4"), 60, 480, 270);
  }
  mallopt(M_PERTURB, 0);
  cpu_set_t all, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof(all), &all), 0);
  CPU_ZERO(&one);
  int core = 0;
  while (!CPU_ISSET(core, &all)) ++core;
  CPU_SET(core, &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof(one), &one), 0);
  WriteVideo(folder / "v-core.mp4", 60, 480, 270);
  sched_setaffinity(0, sizeof(all), &all);
  const std::string first = Slurp(folder / "v0.mp4");
  EXPECT_GT(first.size(), 1000u);
  for (const char* other : {"v1.mp4", "v85.mp4", "v254.mp4", "v-core.mp4"})
    EXPECT_TRUE(first == Slurp(folder / other)) << other;
}

TEST(Video, ColoursAndGreyComeBack) {
  Scratch folder("colours");
  Image colour{64, 48, 3, {}};
  for (int k = 0; k < 64 * 48; ++k)
    for (const int value : {30, 60, 200}) colour.data.push_back(static_cast<std::uint8_t>(value));
  {
    VideoWriter writer(folder / "v.mp4", 64, 48, 25);
    for (int k = 0; k < 5; ++k) writer.Write(colour);
    for (const std::uint8_t grey : {40, 220})
      writer.Write(Image{64, 48, 1, std::vector<std::uint8_t>(64 * 48, grey)});
    writer.Write(colour);
    writer.Finish();
  }
  const auto source = OpenVideo(folder / "v.mp4");
  std::vector<Frame> frames;
  while (auto frame = source->Next()) frames.push_back(*frame);
  ASSERT_EQ(frames.size(), 8u);
  const std::size_t middle = 3 * (24 * 64 + 32);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(frames[0].image->data[middle + k], colour.data[k], 4);
    EXPECT_NEAR(frames[5].image->data[middle + k], 40, 4);
    EXPECT_NEAR(frames[6].image->data[middle + k], 220, 4);
    EXPECT_NEAR(frames[7].image->data[middle + k], colour.data[k], 4);
  }
}

TEST(Video, WhatCannotBeBegunLeavesNothingEither) {
  Scratch folder("never-begun");
  fs::create_symlink("/dev/full", folder / "v.part.mp4");
  MessageOf([&] { VideoWriter writer(folder / "v.mp4", 64, 48, 25); });
  EXPECT_TRUE(fs::is_empty(folder.Path()));
}

TEST(Video, NamesMayHaveAColon) {
  Scratch folder("colon");
  fs::create_directories(folder / "a:b");
  WriteVideo(folder / "a:b/v:1.mp4", 3);
  EXPECT_TRUE(fs::exists(folder / "a:b/v:1.mp4"));
}

TEST(Video, AFullDiskIsSaidAndLeavesNothing) {
  Scratch folder("full");
  fs::create_symlink("/dev/full", folder / "v.part.mp4");
  const std::string message = MessageOf([&] {
    VideoWriter writer(folder / "v.mp4", 64, 48, 25);
    for (int k = 0; k < 50; ++k) writer.Write(ToImage(Tissue(64, 48, k)));
    writer.Finish();
  });
  EXPECT_NE(message.find("v.mp4"), std::string::npos) << message;
  EXPECT_NE(message.find("No space left"), std::string::npos) << message;
  EXPECT_TRUE(fs::is_empty(folder.Path()));
}

TEST(Video, DecodingIsDeterministic) {
  Scratch folder("twice");
  WriteVideo(folder / "v.mp4", 12);
  const auto a = OpenVideo(folder / "v.mp4"), b = OpenVideo(folder / "v.mp4");
  while (const auto frame = a->Next()) {
    const auto other = b->Next();
    ASSERT_TRUE(other);
    EXPECT_EQ(frame->image->data, other->image->data);
  }
}

TEST(Video, AnyFrameIsFoundAgain) {
  Scratch folder("place");
  WriteVideo(folder / "v.mp4", 60);
  const auto video = OpenVideo(folder / "v.mp4"), reader = OpenVideo(folder / "v.mp4");
  std::vector<Frame> frames;
  while (auto frame = reader->Next()) frames.push_back(*frame);
  ASSERT_EQ(frames.size(), 60u);
  for (const int wanted : {40, 41, 3, 59, 0, 27}) {
    ASSERT_TRUE(video->GoTo(wanted));
    const auto frame = video->Next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->index, wanted);
    EXPECT_EQ(frame->image->data, frames[wanted].image->data) << "frame " << wanted;
  }
  EXPECT_FALSE(video->GoTo(-1));
}

TEST(Video, UnfinishedWritingLeavesNothing) {
  Scratch folder("unfinished");
  {
    VideoWriter writer(folder / "v.mp4", 64, 48, 25);
    writer.Write(ToImage(Tissue(64, 48, 1)));
  }
  EXPECT_TRUE(fs::is_empty(folder.Path()));
}

TEST(Video, OddSizesLoseTheLastRowOnly) {
  Scratch folder("odd");
  WriteVideo(folder / "v.mp4", 3, 161, 121);
  const auto source = OpenVideo(folder / "v.mp4");
  EXPECT_EQ(source->Width(), 160);
  EXPECT_EQ(source->Height(), 120);
}

TEST(Video, WriterRefusesAnotherSize) {
  Scratch folder("size");
  VideoWriter writer(folder / "v.mp4", 64, 48, 25);
  writer.Write(ToImage(Tissue(64, 48, 1)));
  EXPECT_NE(MessageOf([&] { writer.Write(ToImage(Tissue(62, 48, 1))); }).find("frame 1"),
            std::string::npos);
  EXPECT_THROW(VideoWriter(folder / "missing/v.mp4", 64, 48, 25), InputError);
  EXPECT_THROW(VideoWriter(folder / "w.mp4", 0, 48, 25), InputError);
}

TEST(Video, UnreadableFilesAreRefusedByName) {
  Scratch folder("bad");
  EXPECT_THROW(OpenVideo(folder / "none.mp4"), InputError);
  Spill(folder / "empty.mp4", "");
  EXPECT_NE(MessageOf([&] { OpenVideo(folder / "empty.mp4"); }).find("empty.mp4"),
            std::string::npos);
  Spill(folder / "noise.mp4", std::string(5000, 'x'));
  EXPECT_THROW(OpenVideo(folder / "noise.mp4"), InputError);
  WriteVideo(folder / "v.mp4", 20);
  const std::string bytes = Slurp(folder / "v.mp4");
  // The index is at the end: without it nothing can be read.
  Spill(folder / "truncated.mp4", bytes.substr(0, bytes.size() / 2));
  EXPECT_THROW(OpenVideo(folder / "truncated.mp4"), InputError);
  WriteVideo(folder / "one.mp4", 1);
  EXPECT_NE(MessageOf([&] { OpenVideo(folder / "one.mp4"); }).find("frame 1"), std::string::npos);
  VideoOptions still;
  still.minimum_frames = 1;
  EXPECT_NO_THROW(OpenVideo(folder / "one.mp4", still));
}

TEST(Video, BreakInTheMiddleKeepsWhatWasRead) {
  Scratch folder("break");
  // Motion JPEG in AVI: the index is not needed, so a cut file plays up to the cut.
  {
    cv::VideoWriter writer(folder / "v.avi", cv::CAP_FFMPEG,
                           cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, {160, 120}, true);
    for (int i = 0; i < 20; ++i) writer.write(Numbered(160, 120, i));
  }
  const std::string bytes = Slurp(folder / "v.avi");
  Spill(folder / "cut.avi", bytes.substr(0, bytes.size() * 6 / 10));
  const auto source = OpenVideo(folder / "cut.avi");
  int read = 0;
  while (const auto frame = source->Next()) EXPECT_EQ(NumberOf(*frame->image), read++);
  EXPECT_GT(read, 5);
  EXPECT_LT(read, 15);
  EXPECT_TRUE(source->Broken());
  EXPECT_NE(source->BreakReport().find("frame " + std::to_string(read)), std::string::npos)
      << source->BreakReport();
}

TEST(Video, SizeChangeInsideAStreamIsSeen) {
  Scratch folder("resize");
  const auto write = [&](const std::string& name, int width, int height) {
    cv::VideoWriter writer(folder / name, cv::CAP_FFMPEG,
                           cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, {width, height}, true);
    for (int i = 0; i < 5; ++i) writer.write(Numbered(width, height, i));
  };
  write("a.mjpeg", 160, 120);
  write("b.mjpeg", 128, 96);
  Spill(folder / "both.mjpeg", Slurp(folder / "a.mjpeg") + Slurp(folder / "b.mjpeg"));
  const auto source = OpenVideo(folder / "both.mjpeg");
  int read = 0;
  const std::string message = MessageOf([&] {
    while (source->Next()) ++read;
  });
  EXPECT_EQ(read, 5);
  EXPECT_NE(message.find("frame 5"), std::string::npos) << message;
  EXPECT_NE(message.find("128 x 96"), std::string::npos) << message;
}

TEST(Video, H264ParameterSetsGiveTheSize) {
  // Two parameter sets of the high profile, written by x264 for 960 × 540 and 640 × 360, before a
  // picture.
  const std::uint8_t large[] = {0,    0,    0,    1,    0x67, 0x64, 0x00, 0x1f, 0xac,
                                0xd9, 0x40, 0xf0, 0x11, 0x7e, 0xe1, 0x00, 0x00, 0x03,
                                0x00, 0x01, 0x00, 0x00, 0x03, 0x00, 0x32, 0x0f, 0x18,
                                0x31, 0x96, 0,    0,    1,    0x65, 0x88};
  const auto size = EncodedSize(large, sizeof large);
  ASSERT_TRUE(size);
  EXPECT_EQ(size->first, 960);
  EXPECT_EQ(size->second, 540);
  const std::uint8_t picture[] = {0, 0, 0, 1, 0x65, 0x88, 0x84, 0, 0, 1, 0x67, 0x64, 0, 0x1f, 0xac};
  EXPECT_FALSE(EncodedSize(picture, sizeof picture));
  EXPECT_FALSE(EncodedSize(large, 9));
  EXPECT_FALSE(EncodedSize(nullptr, 0));
}

TEST(ImageSequence, FolderInNaturalOrder) {
  Scratch folder("folder");
  for (const int i : {1, 2, 10, 3})
    cv::imwrite(folder / ("f" + std::to_string(i) + ".png"), Numbered(80, 60, i));
  Spill(folder / "notes.txt", "no image");
  const auto source = OpenVideo(folder.Path());
  EXPECT_EQ(source->FrameCount(), 4);
  for (const int i : {1, 2, 3, 10}) EXPECT_EQ(NumberOf(*source->Next()->image), i);
  EXPECT_FALSE(source->Next());
  EXPECT_FALSE(source->Broken());
}

TEST(ImageSequence, PatternStopsAtAGap) {
  Scratch folder("pattern");
  for (const int i : {7, 8, 9, 12}) {
    char name[32];
    std::snprintf(name, sizeof name, "f%04d.png", i);
    cv::imwrite(folder / name, Numbered(80, 60, i));
  }
  const auto source = OpenVideo(folder / "f%04d.png");
  for (const int i : {7, 8, 9}) EXPECT_EQ(NumberOf(*source->Next()->image), i);
  EXPECT_FALSE(source->Next());
  EXPECT_TRUE(source->Broken());
  EXPECT_NE(source->BreakReport().find("10"), std::string::npos);
  EXPECT_THROW(OpenVideo(folder / "g%04d.png"), InputError);
  EXPECT_THROW(OpenVideo(folder / "f%s.png"), InputError);
}

TEST(ImageSequence, BrokenImageAndChangedSize) {
  Scratch folder("broken");
  for (int i = 0; i < 5; ++i)
    cv::imwrite(folder / (std::to_string(i) + ".png"), Numbered(80, 60, i));
  Spill(folder / "3.png", "not an image");
  const auto source = OpenVideo(folder.Path());
  int read = 0;
  while (source->Next()) ++read;
  EXPECT_EQ(read, 3);
  EXPECT_NE(source->BreakReport().find("3.png"), std::string::npos) << source->BreakReport();
  cv::imwrite(folder / "3.png", Numbered(82, 60, 3));
  const auto resized = OpenVideo(folder.Path());
  for (int i = 0; i < 3; ++i) resized->Next();
  EXPECT_NE(MessageOf([&] { resized->Next(); }).find("frame 3"), std::string::npos);
  Scratch nothing("nothing");
  EXPECT_THROW(OpenVideo(nothing.Path()), InputError);
}

TEST(ImageSequence, NaturalOrderIsAnOrder) {
  EXPECT_TRUE(NaturalLess("f2", "f10"));
  EXPECT_FALSE(NaturalLess("f10", "f2"));
  EXPECT_TRUE(NaturalLess("a9b", "a10a"));
  EXPECT_TRUE(NaturalLess("a", "a1"));
  EXPECT_FALSE(NaturalLess("x", "x"));
  EXPECT_NE(NaturalLess("f01", "f1"), NaturalLess("f1", "f01"));
}

}  // namespace
