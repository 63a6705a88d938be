#include "Adapters/Ffmpeg/VideoWriter.h"

#include <algorithm>
#include <filesystem>
#include <utility>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include "Core/Errors.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

/// libx264's result depends on the number of its threads, not on their timing.
constexpr int kThreads = 2;
/// libx264's rate control by macroblock tree reads memory that nobody has written (version 164):
/// the same frames give other files from run to run. Some of its AVX2 code rounds unlike the rest.
constexpr const char* kSameEverywhere = "mbtree=0:cpu-independent=1";
constexpr const char* kQuality = "23";                    // libx264's own default
constexpr int kMpeg4Quantizer = 3, kLargestRate = 65535;  // MPEG-4's clock has 16 bits

struct Closing {
  void operator()(AVFormatContext* context) const {
    avio_closep(&context->pb);
    avformat_free_context(context);
  }
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(SwsContext* context) const { sws_freeContext(context); }
};

template <class T>
using Owned = std::unique_ptr<T, Closing>;

std::string Explanation(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof(text));
  return text;
}

/// None when the encoder is missing or refuses.
Owned<AVCodecContext> OpenEncoder(const AVCodec* codec, int width, int height, AVRational rate,
                                  bool global_header) {
  if (!codec) return nullptr;
  Owned<AVCodecContext> encoder(avcodec_alloc_context3(codec));
  encoder->width = width;
  encoder->height = height;
  encoder->time_base = av_inv_q(rate);
  encoder->framerate = rate;
  encoder->pix_fmt = AV_PIX_FMT_YUV420P;
  encoder->color_range = AVCOL_RANGE_MPEG;
  encoder->colorspace = AVCOL_SPC_SMPTE170M;
  encoder->thread_count = kThreads;
  encoder->log_level_offset = AV_LOG_TRACE;
  if (codec->id == AV_CODEC_ID_H264) {
    av_opt_set(encoder->priv_data, "crf", kQuality, 0);
    av_opt_set(encoder->priv_data, "x264-params", kSameEverywhere, 0);
  } else {
    encoder->flags |= AV_CODEC_FLAG_QSCALE;
    encoder->global_quality = FF_QP2LAMBDA * kMpeg4Quantizer;
  }
  if (global_header) encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  if (avcodec_open2(encoder.get(), codec, nullptr) < 0) return nullptr;
  return encoder;
}

}  // namespace

struct VideoWriter::Implementation {
  std::string path, part, message;
  int width = 0, height = 0, frames = 0;
  Owned<AVFormatContext> file;
  Owned<AVCodecContext> encoder;
  Owned<AVFrame> source, picture;
  Owned<AVPacket> packet;
  Owned<SwsContext> conversion;
  AVStream* stream = nullptr;
  bool begun = false, finished = false;

  ~Implementation() {
    if (!begun || finished) return;
    file.reset();
    std::error_code ignored;
    fs::remove(part, ignored);
  }

  void Check(int status, const std::string& what) const {
    if (status < 0) throw InputError(path, what, "cannot be written: " + Explanation(status));
  }

  /// @param frame null: whatever the encoder still holds
  void Encode(const AVFrame* frame, const std::string& what) {
    Check(avcodec_send_frame(encoder.get(), frame), what);
    while (true) {
      const int status = avcodec_receive_packet(encoder.get(), packet.get());
      if (status == AVERROR(EAGAIN) || status == AVERROR_EOF) return;
      Check(status, what);
      av_packet_rescale_ts(packet.get(), encoder->time_base, stream->time_base);
      packet->stream_index = stream->index;
      Check(av_interleaved_write_frame(file.get(), packet.get()), what);
      // What the disk refuses is kept by the file until it is asked.
      Check(file->pb->error, what);
    }
  }

  void Convert(const Image& image) {
    const AVPixelFormat wanted = image.channels == 1 ? AV_PIX_FMT_GRAY8 : AV_PIX_FMT_BGR24;
    if (!source || source->format != wanted) {
      source.reset();
      Owned<AVFrame> fresh = NewFrame(wanted);
      // Bit-exact: the same picture from every processor's instructions.
      conversion.reset(sws_getContext(encoder->width, encoder->height, wanted, encoder->width,
                                      encoder->height, AV_PIX_FMT_YUV420P,
                                      SWS_BICUBIC | SWS_ACCURATE_RND | SWS_BITEXACT, nullptr,
                                      nullptr, nullptr));
      if (!conversion) Check(AVERROR(ENOMEM), "");
      source = std::move(fresh);
    }
    // Copied: swscale reads a few bytes beyond the end of a row.
    const std::size_t row = std::size_t(encoder->width) * image.channels;
    for (int y = 0; y < encoder->height; ++y)
      std::copy_n(image.data.data() + std::size_t(y) * image.width * image.channels, row,
                  source->data[0] + std::ptrdiff_t(y) * source->linesize[0]);
    Check(av_frame_make_writable(picture.get()), "");
    sws_scale(conversion.get(), source->data, source->linesize, 0, encoder->height, picture->data,
              picture->linesize);
  }

  Owned<AVFrame> NewFrame(AVPixelFormat format) const {
    Owned<AVFrame> frame(av_frame_alloc());
    if (!frame) Check(AVERROR(ENOMEM), "");
    frame->format = format;
    frame->width = encoder->width;
    frame->height = encoder->height;
    Check(av_frame_get_buffer(frame.get(), 0), "");
    return frame;
  }
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

  const std::string url = "file:" + self.part;  // a colon in a name is no protocol
  AVFormatContext* file = nullptr;
  self.Check(avformat_alloc_output_context2(&file, nullptr, "mp4", url.c_str()), "");
  self.file.reset(file);
  const AVRational rate = av_d2q(frames_per_second, kLargestRate);
  const bool global_header = file->oformat->flags & AVFMT_GLOBALHEADER;
  const auto open = [&](const AVCodec* codec) {
    self.encoder = OpenEncoder(codec, width & ~1, height & ~1, rate, global_header);
    return self.encoder != nullptr;
  };
  if (!open(avcodec_find_encoder_by_name("libx264"))) {
    if (!open(avcodec_find_encoder(AV_CODEC_ID_MPEG4)))
      throw InputError(path, "", "neither an H.264 nor an MPEG-4 encoder could be opened");
    self.message = path + ": H.264 could not be had (libx264), MPEG-4 part 2 is used instead";
  }
  self.stream = avformat_new_stream(file, nullptr);
  if (!self.stream) self.Check(AVERROR(ENOMEM), "");
  self.stream->time_base = self.encoder->time_base;
  self.stream->avg_frame_rate = rate;
  self.Check(avcodec_parameters_from_context(self.stream->codecpar, self.encoder.get()), "");
  self.picture = self.NewFrame(AV_PIX_FMT_YUV420P);
  self.picture->quality = self.encoder->global_quality;
  self.packet.reset(av_packet_alloc());
  if (!self.packet) self.Check(AVERROR(ENOMEM), "");
  self.Check(avio_open(&file->pb, url.c_str(), AVIO_FLAG_WRITE), "");
  self.begun = true;
  self.Check(avformat_write_header(file, nullptr), "");
}

VideoWriter::~VideoWriter() = default;

void VideoWriter::Write(const Image& image) {
  Implementation& self = *implementation_;
  const std::string name = "frame " + std::to_string(self.frames);
  if (image.width != self.width || image.height != self.height)
    throw InputError(self.path, name,
                     "the image is " + std::to_string(image.width) + " x " +
                         std::to_string(image.height) + ", the video " +
                         std::to_string(self.width) + " x " + std::to_string(self.height));
  if ((image.channels != 1 && image.channels != 3) ||
      image.data.size() != std::size_t(image.width) * image.height * image.channels)
    throw InputError(self.path, name, "the image is neither grey nor BGR");
  self.Convert(image);
  self.picture->pts = self.frames;
  self.Encode(self.picture.get(), name);
  ++self.frames;
}

void VideoWriter::Finish() {
  Implementation& self = *implementation_;
  if (self.finished) return;
  self.Encode(nullptr, "");
  self.Check(av_write_trailer(self.file.get()), "");
  self.Check(avio_closep(&self.file->pb), "");
  self.file.reset();
  std::error_code error;
  fs::rename(self.part, self.path, error);
  if (error) throw InputError(self.path, "", "cannot be completed: " + error.message());
  self.finished = true;
}

int VideoWriter::FrameCount() const { return implementation_->frames; }
const std::string& VideoWriter::Message() const { return implementation_->message; }

}  // namespace kerf
