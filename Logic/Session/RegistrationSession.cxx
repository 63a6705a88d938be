#include "Session/RegistrationSession.h"

#include <exception>
#include <utility>

#include "Session/StageClock.h"

namespace kerf {
RegistrationSession::RegistrationSession(TetMesh mesh, std::vector<Structure> structures,
                                         CameraModel camera, MethodOptions options,
                                         std::unique_ptr<FeatureTracker> tracker,
                                         std::unique_ptr<OrganSegmenter> segmenter)
    : mesh_(std::move(mesh)),
      structures_(std::move(structures)),
      camera_(std::move(camera)),
      options_(std::move(options)),
      tracker_(std::move(tracker)),
      segmenter_(std::move(segmenter)),
      solvers_{options_.method == Method::Reference ? MakeReferenceSolver() : MakeKerfSolver(),
               options_.grips ? MakeKerfSolver() : nullptr},
      clock_(std::make_unique<StageClock>()) {
  options_.Validate();
}

RegistrationSession::~RegistrationSession() = default;

Engine RegistrationSession::MakeEngine() {
  return Engine{*tracker_, solvers_, cutter_, clock_.get(), segmenter_.get(), &search_};
}

RegistrationSession::WholeOrBefore::WholeOrBefore(RegistrationState* state)
    : state_(state), before_(*state), thrown_(std::uncaught_exceptions()) {}

RegistrationSession::WholeOrBefore::~WholeOrBefore() {
  if (std::uncaught_exceptions() > thrown_) std::swap(*state_, before_);
}

SessionFrame RegistrationSession::Process(const Frame& frame) {
  Engine engine = MakeEngine();
  if (!started_) {
    state_ = Initialize(frame, camera_, std::move(mesh_), std::move(structures_), options_, engine);
    for (Index i = 0; i < state_.features.Size(); ++i)
      if (state_.features.status[i] == FeatureStatus::Tracked && state_.bound.on_surface[i])
        ++initially_tracked_;
    started_ = true;
  }
  SessionFrame out;
  out.frame = frame.index;
  out.time_s = frame.time_s;
  if (history_kept_) before_ = state_;
  clock_->Start();
  try {
    out.step = Step(frame, camera_, options_, engine, &state_);
  } catch (...) {
    if (history_kept_) std::swap(state_, before_);
    throw;
  }
  out.times = clock_->Finish();
  if (history_kept_) NoteCuts(out.step);
  out.reliability = AssessReliability(state_, camera_, initially_tracked_, &out.step);
  watch_.WatchPicture(frame, &out.reliability);
  watch_.WatchLeap(frame.time_s, out.step.leap_mm, &out.reliability);
  watch_.WatchRate(frame.time_s, &out.reliability);
  return out;
}

}  // namespace kerf
