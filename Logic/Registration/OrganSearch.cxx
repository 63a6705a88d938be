#include "Registration/OrganSearch.h"

#include "Registration/OrganMask.h"

namespace kerf {

OrganSearch::~OrganSearch() {
  group_.cancel();
  try {
    group_.wait();
  } catch (...) {  // NOLINT(bugprone-empty-catch): nobody is left who asked for it
  }
}

void OrganSearch::Begin(SurfaceMesh outline) {
  outline_ = std::move(outline);
  group_.run([this] {
    found_.model = ProjectedMask(outline_, camera_);
    found_.organ = segmenter_.Segment(frame_, found_.model);
  });
}

OrganSearch::Found& OrganSearch::Wait() {
  group_.wait();
  return found_;
}

}  // namespace kerf
