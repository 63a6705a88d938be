#include "Pipelines/RegistrationParts.h"

#include "Adapters/OpenCv/OrganSegmentation.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

class VideoOrganSegmenter : public OrganSegmenter {
 public:
  Image Segment(const Frame& frame, const Image& model_mask) override {
    return OrganMask(frame, model_mask);
  }
};

}  // namespace

std::unique_ptr<OrganSegmenter> MakeVideoOrganSegmenter() {
  return std::make_unique<VideoOrganSegmenter>();
}

void CheckVideoSize(int width, int height, const std::string& video, const CameraModel& camera,
                    const std::string& camera_file) {
  if (width == camera.width && height == camera.height) return;
  throw InputError(video, "frame size",
                   std::to_string(width) + "×" + std::to_string(height) + ", but " + camera_file +
                       " is for " + std::to_string(camera.width) + "×" +
                       std::to_string(camera.height));
}

}  // namespace kerf
