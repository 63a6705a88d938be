#include "Intraoperative/OverlayPainter.h"

#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <deque>
#include <future>
#include <mutex>
#include <thread>
#include <utility>

#include "Adapters/OpenCv/ImageMasks.h"
#include "Adapters/Rendering/OverlayRenderer.h"
#include "Core/ThreadPriority.h"

namespace kerf {
namespace {

OverlayStructure::Kind KindOf(const std::string& name) {
  return name == "tumour" ? OverlayStructure::Kind::Tumour : OverlayStructure::Kind::Internal;
}

OverlayStatus::Gate GateOf(GateState state) {
  return state == GateState::Green   ? OverlayStatus::Gate::Green
         : state == GateState::Amber ? OverlayStatus::Gate::Amber
                                     : OverlayStatus::Gate::Off;
}

/// What is drawn in which way.
struct Look {
  OverlayOptions options;
  double margin_alarm_mm = 5.0;
};

Image PaintSnapshot(const IntraoperativeSnapshot& snapshot, const Look& look,
                    OverlayRenderer* renderer) {
  OverlayScene scene;
  scene.frame = snapshot.frame;
  scene.organ = &snapshot.organ;
  scene.organ_cut_face = snapshot.organ_cut_face;
  for (const auto& part : snapshot.structures)
    scene.structures.push_back({KindOf(part.name), &part.surface});
  const auto add = [&](const std::vector<Points>& lines, OverlayLine::Kind kind) {
    for (const Points& line : lines) scene.lines.push_back({kind, line});
  };
  add(snapshot.planned_lines, OverlayLine::Kind::Planned);
  add(snapshot.applied_lines, OverlayLine::Kind::Applied);
  add(snapshot.proposed_lines, OverlayLine::Kind::Proposed);
  const Image instruments = InstrumentMask(snapshot.frame);
  if (snapshot.frame.image) scene.instruments = &instruments;
  scene.status.gate = GateOf(snapshot.gate);
  scene.status.reason = snapshot.reason;
  scene.status.tumour_u95_mm = snapshot.reliability.tumour_u95_mm;
  scene.status.margin_mm = snapshot.margin_mm;
  scene.status.planned_margin_mm = snapshot.planned_margin_mm;
  scene.status.margin_alarm_mm = look.margin_alarm_mm;
  if (snapshot.gate != GateState::Off && std::isfinite(snapshot.deviation.mean_mm)) {
    char note[64];
    std::snprintf(note, sizeof note, "plan to cut %.1f mm, at most %.1f",
                  snapshot.deviation.mean_mm, snapshot.deviation.max_mm);
    scene.status.note = note;
  }
  renderer->SetOptions(look.options);
  return renderer->Render(scene);
}

}  // namespace

struct OverlayPainter::Implementation {
  using Work = std::function<void(OverlayRenderer*)>;

  // The window's.
  Look look;
  // Of both threads.
  std::mutex mutex;
  std::condition_variable changed;
  bool stop = false;
  std::deque<Work> at_once;
  struct Order {
    std::shared_ptr<const IntraoperativeSnapshot> snapshot;
    Look look;
  };
  std::optional<Order> order;
  int forgotten = 0;  ///< grows with every Forget()
  std::optional<Painted> painted;
  std::exception_ptr problem;
  std::function<void()> on_painted;
  std::thread thread;

  void Run(const CameraModel& camera, std::promise<void> started);
  void PaintOrder(OverlayRenderer* renderer, std::unique_lock<std::mutex>* lock);
  /// Runs `work` in the painter's thread and waits for it; throws what it throws.
  void AtOnce(const std::function<void(OverlayRenderer*)>& work);
};

void OverlayPainter::Implementation::PaintOrder(OverlayRenderer* renderer,
                                                std::unique_lock<std::mutex>* lock) {
  const Order now = std::move(*order);
  order.reset();
  const int wanted = forgotten;
  lock->unlock();
  std::optional<Painted> done;
  std::exception_ptr failed;
  try {
    done = Painted{now.snapshot, PaintSnapshot(*now.snapshot, now.look, renderer)};
  } catch (...) {
    failed = std::current_exception();
  }
  lock->lock();
  if (wanted != forgotten) return;
  painted = std::move(done);
  problem = failed;
  if (!on_painted) return;
  lock->unlock();
  on_painted();
  lock->lock();
}

/// The renderer lives and dies here: its OpenGL context belongs to this thread, and the threads
/// that draw for it get this one's priority.
void OverlayPainter::Implementation::Run(const CameraModel& camera, std::promise<void> started) {
  StepBehindOthers();
  std::unique_ptr<OverlayRenderer> renderer;
  try {
    renderer = std::make_unique<OverlayRenderer>(camera);
  } catch (...) {
    started.set_exception(std::current_exception());
    return;
  }
  started.set_value();
  std::unique_lock lock(mutex);
  while (true) {
    changed.wait(lock, [&] { return stop || order || !at_once.empty(); });
    if (!at_once.empty()) {
      const Work work = std::move(at_once.front());
      at_once.pop_front();
      lock.unlock();
      work(renderer.get());
      lock.lock();
    } else if (stop) {
      return;
    } else {
      PaintOrder(renderer.get(), &lock);
    }
  }
}

void OverlayPainter::Implementation::AtOnce(const std::function<void(OverlayRenderer*)>& work) {
  const auto done = std::make_shared<std::promise<void>>();
  auto finished = done->get_future();
  {
    const std::lock_guard lock(mutex);
    at_once.push_back([&work, done](OverlayRenderer* renderer) {
      try {
        work(renderer);
        done->set_value();
      } catch (...) {
        done->set_exception(std::current_exception());
      }
    });
  }
  changed.notify_one();
  finished.get();
}

OverlayPainter::OverlayPainter(const CameraModel& camera, std::function<void()> on_painted)
    : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  self.on_painted = std::move(on_painted);
  std::promise<void> started;
  auto ready = started.get_future();
  self.thread = std::thread([&self, camera, started = std::move(started)]() mutable {
    self.Run(camera, std::move(started));
  });
  try {
    ready.get();
  } catch (...) {
    self.thread.join();
    throw;
  }
}

OverlayPainter::~OverlayPainter() {
  {
    const std::lock_guard lock(implementation_->mutex);
    implementation_->stop = true;
  }
  implementation_->changed.notify_one();
  implementation_->thread.join();
}

void OverlayPainter::SetOptions(const OverlayOptions& options) {
  implementation_->look.options = options;
}

void OverlayPainter::SetMarginAlarm(double mm) { implementation_->look.margin_alarm_mm = mm; }

void OverlayPainter::Begin(std::shared_ptr<const IntraoperativeSnapshot> snapshot) {
  {
    const std::lock_guard lock(implementation_->mutex);
    implementation_->order = Implementation::Order{std::move(snapshot), implementation_->look};
  }
  implementation_->changed.notify_one();
}

std::optional<OverlayPainter::Painted> OverlayPainter::Take() {
  const std::lock_guard lock(implementation_->mutex);
  if (auto problem = std::exchange(implementation_->problem, nullptr))
    std::rethrow_exception(problem);
  return std::exchange(implementation_->painted, std::nullopt);
}

void OverlayPainter::Forget() {
  const std::lock_guard lock(implementation_->mutex);
  ++implementation_->forgotten;
  implementation_->order.reset();
  implementation_->painted.reset();
  implementation_->problem = nullptr;
}

void OverlayPainter::Rest() {
  Forget();
  implementation_->AtOnce([](OverlayRenderer*) {});
}

Image OverlayPainter::Paint(const IntraoperativeSnapshot& snapshot) {
  Image picture;
  implementation_->AtOnce([&](OverlayRenderer* renderer) {
    picture = PaintSnapshot(snapshot, implementation_->look, renderer);
  });
  return picture;
}

Image OverlayPainter::PaintExposure(const CameraModel& camera, const Frame& frame,
                                    const SurfaceMesh& organ,
                                    const std::vector<Structure>& structures) {
  OverlayScene scene;
  scene.frame = frame;
  scene.organ = &organ;
  for (const Structure& structure : structures)
    if (!structure.rest.Empty())
      scene.structures.push_back({KindOf(structure.name), &structure.rest});
  scene.status.gate = OverlayStatus::Gate::Amber;
  scene.status.reason = "registration not accepted yet";
  Image picture;
  implementation_->AtOnce([&](OverlayRenderer* renderer) {
    renderer->SetCamera(camera);
    renderer->SetOptions(implementation_->look.options);
    picture = renderer->Render(scene);
  });
  return picture;
}

}  // namespace kerf
