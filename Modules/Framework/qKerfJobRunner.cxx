#include "Framework/qKerfJobRunner.h"

#include <QElapsedTimer>
#include <QTimer>
#include <atomic>
#include <deque>
#include <exception>
#include <thread>

#include "Core/Errors.h"
#include "Core/ThreadPriority.h"
#include "Session/JobProgress.h"

namespace {

/// Saying it draws the window anew, which takes a hundredth of a second in software.
constexpr int kSaidEvery_ms = 100;

/// What went wrong, then what to do.
QString WithAdvice(QString sentence, const QString& advice) {
  sentence = sentence.trimmed();
  if (sentence.isEmpty() || advice.isEmpty()) return sentence;
  if (!sentence.endsWith('.')) sentence += '.';
  return sentence + ' ' + advice;
}

}  // namespace

struct qKerfJobRunner::Impl {
  std::deque<Job> waiting;
  Job running;
  bool busy = false;
  std::thread worker;
  std::unique_ptr<kerf::JobProgress> progress;
  // Written by the worker before `over`, read by the window after it.
  std::atomic<bool> over{false};
  bool cancelled = false;
  QString sentence;
  double fraction = -1.0;
  QString what;
  QTimer timer;
  QElapsedTimer said;  ///< since progress was told
};

qKerfJobRunner::qKerfJobRunner(QObject* parent) : QObject(parent), impl_(new Impl) {
  impl_->timer.setInterval(30);
  connect(&impl_->timer, &QTimer::timeout, this, &qKerfJobRunner::Look);
}

qKerfJobRunner::~qKerfJobRunner() {
  impl_->waiting.clear();
  if (impl_->progress) impl_->progress->Cancel();
  if (impl_->worker.joinable()) impl_->worker.join();
}

void qKerfJobRunner::Run(Job job) {
  impl_->waiting.push_back(std::move(job));
  if (!impl_->busy) StartNext();
}

bool qKerfJobRunner::IsBusy() const { return impl_->busy; }

QString qKerfJobRunner::Title() const { return impl_->busy ? impl_->running.title : QString(); }

void qKerfJobRunner::Cancel() {
  const std::deque<Job> dropped = std::move(impl_->waiting);
  impl_->waiting.clear();
  if (impl_->busy) impl_->progress->Cancel();
  for (const Job& job : dropped)
    if (job.cancelled) job.cancelled();
}

void qKerfJobRunner::StartNext() {
  if (impl_->waiting.empty()) return;
  impl_->running = std::move(impl_->waiting.front());
  impl_->waiting.pop_front();
  impl_->busy = true;
  impl_->over = false;
  impl_->cancelled = false;
  impl_->sentence.clear();
  impl_->fraction = -1.0;
  impl_->what.clear();
  impl_->said.invalidate();
  impl_->progress = std::make_unique<kerf::JobProgress>();
  emit Started(impl_->running.title);
  impl_->worker = std::thread([impl = impl_.get()] {
    kerf::StepBehindOthers();  // drawing must not wait for a filter that uses all cores
    try {
      impl->running.work(*impl->progress);
    } catch (const kerf::Cancelled&) {
      impl->cancelled = true;
    } catch (const std::bad_alloc&) {
      impl->sentence = QStringLiteral("There is not enough memory for this; close other programs.");
    } catch (const std::exception& error) {
      impl->sentence = QString::fromUtf8(error.what());
      if (impl->sentence.isEmpty()) impl->sentence = QStringLiteral("It failed without a reason.");
    }
    impl->over = true;
  });
  impl_->timer.start();
}

void qKerfJobRunner::Look() {
  const bool over = impl_->over;
  const kerf::JobProgress::State state = impl_->progress->Take();
  for (const std::string& warning : state.warnings) emit Warned(QString::fromStdString(warning));
  const QString what = QString::fromStdString(state.what);
  const bool soon = impl_->said.isValid() && impl_->said.elapsed() < kSaidEvery_ms;
  if (!soon && (state.fraction != impl_->fraction || what != impl_->what)) {
    impl_->said.start();
    impl_->fraction = state.fraction;
    impl_->what = what;
    emit Progressed(state.fraction, what);
  }
  if (over) Finish();
}

void qKerfJobRunner::Finish() {
  impl_->timer.stop();
  impl_->worker.join();
  const Job job = std::move(impl_->running);
  // Work that ended in spite of a late cancel was still not wanted any more.
  const bool cancelled = impl_->cancelled || impl_->progress->IsCancelled();
  const QString sentence = cancelled ? QString() : WithAdvice(impl_->sentence, job.advice);
  impl_->running = Job();
  impl_->busy = false;
  emit Finished(job.title, sentence, cancelled);
  if (cancelled) {
    if (job.cancelled) job.cancelled();
  } else if (!sentence.isEmpty()) {
    if (job.failed) job.failed(sentence);
  } else if (job.done) {
    job.done();
  }
  if (!impl_->busy) StartNext();
}
