#include "Adapters/OpenCv/VideoSource.h"

#include <cstdlib>
#include <deque>
#include <filesystem>
#include <opencv2/videoio.hpp>

#include "Adapters/OpenCv/CvMats.h"
#include "Adapters/OpenCv/EncodedSize.h"
#include "Adapters/OpenCv/ImageSequence.h"
#include "Core/Errors.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

constexpr int kOpen_ms = 6000, kSilent_ms = 2000;  // of a network stream

std::string SizeText(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

/// Numbers the frames, guards their size and holds back the first ones that were read to check the
/// source.
class CheckedSource : public VideoSource {
 public:
  CheckedSource(std::string path, const VideoOptions& options)
      : path_(std::move(path)), options_(options) {}

  /// Reads the first frames, so that a source that cannot serve is refused before any work is done.
  void Check() {
    const int wanted = std::max(1, options_.minimum_frames);
    while (static_cast<int>(ahead_.size()) < wanted) {
      std::optional<Image> image = Read();
      if (!image) break;
      if (ahead_.empty()) {
        width_ = image->width;
        height_ = image->height;
      }
      ahead_.push_back(std::move(*image));
    }
    if (ahead_.empty())
      throw InputError(path_, "frame 0", "no frame can be read: empty, truncated or not a video");
    if (static_cast<int>(ahead_.size()) < wanted)
      throw InputError(path_, "frame " + std::to_string(ahead_.size()),
                       "only " + std::to_string(ahead_.size()) + " frame can be read, " +
                           std::to_string(wanted) + " are needed");
  }

  std::optional<Frame> Next() override {
    std::optional<Image> image;
    if (!ahead_.empty()) {
      image = std::move(ahead_.front());
      ahead_.pop_front();
    } else {
      image = Read();
    }
    if (!image) {
      if (!Broken()) break_report_ = MissingAfter(index_);
      return std::nullopt;
    }
    if (image->width != width_ || image->height != height_)
      throw InputError(path_, "frame " + std::to_string(index_),
                       "the size changes from " + SizeText(width_, height_) + " to " +
                           SizeText(image->width, image->height));
    Frame frame;
    frame.index = index_;
    frame.time_s = index_ / FramesPerSecond();
    frame.image = std::make_shared<const Image>(std::move(*image));
    ++index_;
    return frame;
  }
  bool GoTo(int index) override {
    if (index < 0 || !Place(index)) return false;
    ahead_.clear();
    index_ = index;
    return true;
  }
  int Width() const override { return width_; }
  int Height() const override { return height_; }

 protected:
  virtual bool Place(int index) = 0;
  virtual std::optional<Image> Read() = 0;
  /// What to say when reading ended after `delivered` frames; empty when that is the proper end.
  virtual std::string MissingAfter(int delivered) const = 0;
  std::string BreakSentence(int delivered, int announced) const {
    return path_ + ": breaks at frame " + std::to_string(delivered) + " of " +
           std::to_string(announced) + "; the frames before it are used";
  }

  std::string path_;
  VideoOptions options_;

 private:
  std::deque<Image> ahead_;
  int index_ = 0, width_ = 0, height_ = 0;
};

class StreamSource : public CheckedSource {
 public:
  StreamSource(const std::string& path, const VideoOptions& options, bool live)
      : CheckedSource(path, options) {
    SilenceFfmpeg();
    const bool device = path.rfind("/dev/", 0) == 0;
    std::vector<int> parameters;
    // A stream that has gone silent is given up early, so that it can be opened anew.
    if (live && !device)
      parameters = {cv::CAP_PROP_OPEN_TIMEOUT_MSEC, kOpen_ms, cv::CAP_PROP_READ_TIMEOUT_MSEC,
                    kSilent_ms};
    if (!capture_.open(path, device ? cv::CAP_V4L2 : cv::CAP_FFMPEG, parameters))
      throw InputError(path, "",
                       live ? "the stream cannot be opened"
                            : "cannot be opened as a video: truncated or not a video");
    fps_ = capture_.get(cv::CAP_PROP_FPS);
    if (!(fps_ > 0.1 && fps_ < 1000)) fps_ = 25.0;
    const double count = live ? -1 : capture_.get(cv::CAP_PROP_FRAME_COUNT);
    count_ = count > 0 && count < 1e8 ? static_cast<int>(count) : -1;
    // Only these containers state their number of frames; elsewhere it is estimated from the
    // duration.
    const std::string suffix = fs::path(path).extension().string();
    // A second reader of the same file, undecoded, sees a change of size that the decoder hides.
    if (!live) packets_.open(path, cv::CAP_FFMPEG, {cv::CAP_PROP_FORMAT, -1});
    exact_count_ = suffix == ".mp4" || suffix == ".mov" || suffix == ".m4v" || suffix == ".avi";
  }
  double FramesPerSecond() const override { return fps_; }
  int FrameCount() const override { return count_; }

 protected:
  bool Place(int index) override {
    if (count_ < 0 || !capture_.set(cv::CAP_PROP_POS_FRAMES, index)) return false;
    packets_.release();  // packets are placed at key frames only
    read_ = index;
    return true;
  }
  std::optional<Image> Read() override {
    cv::Mat mat;
    if (!capture_.read(mat) || mat.empty()) return std::nullopt;
    CheckPacket();
    ++read_;
    return ToImage(mat);
  }
  std::string MissingAfter(int delivered) const override {
    const int slack = exact_count_ ? 0 : 2;
    return delivered + slack < count_ ? BreakSentence(delivered, count_) : "";
  }

 private:
  /// Pictures of another size begin with a key frame, so packet and frame numbers agree there.
  void CheckPacket() {
    cv::Mat packet;
    if (!packets_.isOpened() || !packets_.read(packet) || packet.empty()) return;
    const auto size = EncodedSize(packet.data, packet.total() * packet.elemSize());
    if (!size) return;
    if (!encoded_size_) encoded_size_ = size;
    if (*size != *encoded_size_)
      throw InputError(path_, "frame " + std::to_string(read_),
                       "the size changes from " +
                           SizeText(encoded_size_->first, encoded_size_->second) + " to " +
                           SizeText(size->first, size->second));
  }

  cv::VideoCapture capture_, packets_;
  std::optional<std::pair<int, int>> encoded_size_;
  int read_ = 0;
  double fps_ = 25.0;
  int count_ = -1;
  bool exact_count_ = false;
};

class SequenceSource : public CheckedSource {
 public:
  SequenceSource(const std::string& path, const VideoOptions& options, ImageSequence sequence)
      : CheckedSource(path, options), sequence_(std::move(sequence)) {}
  double FramesPerSecond() const override {
    return options_.frames_per_second > 0 ? options_.frames_per_second : 25.0;
  }
  int FrameCount() const override { return static_cast<int>(sequence_.files.size()); }

 protected:
  bool Place(int index) override {
    next_ = static_cast<std::size_t>(index);
    return true;
  }
  std::optional<Image> Read() override {
    if (next_ >= sequence_.files.size()) return std::nullopt;
    std::optional<Image> image = ReadImageFile(sequence_.files[next_]);
    if (image) ++next_;
    return image;
  }
  std::string MissingAfter(int delivered) const override {
    if (next_ < sequence_.files.size())
      return BreakSentence(delivered, FrameCount()) + " (" + sequence_.files[next_] +
             " cannot be read)";
    if (!sequence_.gap.empty())
      return path_ + ": breaks at frame " + std::to_string(delivered) + ": " + sequence_.gap;
    return "";
  }

 private:
  ImageSequence sequence_;
  std::size_t next_ = 0;
};

}  // namespace

std::unique_ptr<VideoSource> OpenVideo(const std::string& path, const VideoOptions& options) {
  std::unique_ptr<CheckedSource> source;
  if (path.find("://") != std::string::npos || path.rfind("/dev/video", 0) == 0) {
    source = std::make_unique<StreamSource>(path, options, true);
  } else if (path.find('%') != std::string::npos || fs::is_directory(path)) {
    source = std::make_unique<SequenceSource>(path, options, ListImageSequence(path));
  } else {
    std::error_code error;
    if (!fs::exists(path, error)) throw InputError(path, "", "no such file");
    if (fs::is_regular_file(path, error) && fs::file_size(path, error) == 0)
      throw InputError(path, "frame 0", "the file is empty");
    source = std::make_unique<StreamSource>(path, options, false);
  }
  source->Check();
  return source;
}

void SilenceFfmpeg() { setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0); }

}  // namespace kerf
