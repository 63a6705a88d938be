#include "Adapters/OpenCv/VideoWriter.h"

#include <cstdlib>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "Adapters/OpenCv/CvMats.h"
#include "Core/Errors.h"

namespace fs = std::filesystem;

namespace kerf {

struct VideoWriter::Implementation {
  std::string path, part, message;
  int width = 0, height = 0, frames = 0;
  cv::VideoWriter writer;
  bool finished = false;
};

VideoWriter::VideoWriter(const std::string& path, int width, int height, double frames_per_second)
    : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  if (width < 2 || height < 2 || !(frames_per_second > 0))
    throw InputError(path, "", "a video needs a size and a frame rate");
  self.path = path;
  self.width = width;
  self.height = height;
  const fs::path target(path);
  self.part = (target.parent_path() / (target.stem().string() + ".part.mp4")).string();
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
  const cv::Size size(width & ~1, height & ~1);
  const auto open = [&](int fourcc) {
    return self.writer.open(self.part, cv::CAP_FFMPEG, fourcc, frames_per_second, size, true);
  };
  if (!open(cv::VideoWriter::fourcc('a', 'v', 'c', '1'))) {
    if (!open(cv::VideoWriter::fourcc('m', 'p', '4', 'v')))
      throw InputError(path, "", "a video cannot be written there");
    self.message = path + ": no H.264 encoder was found, MPEG-4 part 2 is used instead";
  }
}

VideoWriter::~VideoWriter() {
  if (implementation_->finished) return;
  implementation_->writer.release();
  std::error_code ignored;
  fs::remove(implementation_->part, ignored);
}

void VideoWriter::Write(const Image& image) {
  Implementation& self = *implementation_;
  if (image.width != self.width || image.height != self.height)
    throw InputError(self.path, "frame " + std::to_string(self.frames),
                     "the image is " + std::to_string(image.width) + " x " +
                         std::to_string(image.height) + ", the video " +
                         std::to_string(self.width) + " x " + std::to_string(self.height));
  cv::Mat frame = ViewOf(image);
  if (image.channels == 1) cv::cvtColor(frame, frame, cv::COLOR_GRAY2BGR);
  // A fresh matrix where the encoder takes less than the image: it wants its rows without gaps.
  const cv::Rect even(0, 0, self.width & ~1, self.height & ~1);
  if (even.size() != frame.size()) frame = frame(even).clone();
  self.writer.write(frame);
  ++self.frames;
}

void VideoWriter::Finish() {
  Implementation& self = *implementation_;
  if (self.finished) return;
  self.writer.release();
  std::error_code error;
  if (self.frames > 0 && fs::file_size(self.part, error) == 0)
    error = std::make_error_code(std::errc::io_error);
  if (!error) fs::rename(self.part, self.path, error);
  if (error) throw InputError(self.path, "", "cannot be completed: " + error.message());
  self.finished = true;
}

int VideoWriter::FrameCount() const { return implementation_->frames; }
const std::string& VideoWriter::Message() const { return implementation_->message; }

}  // namespace kerf
