#pragma once

#include <QObject>
#include <QString>
#include <functional>
#include <memory>

namespace kerf {
class Progress;
}

/// Runs work off the GUI thread, one job after another. `work` runs on the worker and touches
/// neither widgets nor what the window changes; the other functions run on the GUI thread.
class qKerfJobRunner : public QObject {
  Q_OBJECT
 public:
  struct Job {
    QString title;  ///< "Segmenting the kidney"
    std::function<void(kerf::Progress&)> work;
    std::function<void()> done;                           ///< may be empty
    std::function<void(const QString& sentence)> failed;  ///< may be empty
    std::function<void()> cancelled;                      ///< may be empty
    QString advice = {};  ///< follows the reason when it fails: what to do
  };

  explicit qKerfJobRunner(QObject* parent = nullptr);
  ~qKerfJobRunner() override;  ///< cancels and waits

  /// Starts the job, or queues it behind the running one.
  void Run(Job job);
  bool IsBusy() const;
  QString Title() const;  ///< of the running job
  /// Asks the running job to stop and drops those that wait.
  void Cancel();

 signals:
  void Started(const QString& title);
  void Progressed(double fraction, const QString& what);
  void Warned(const QString& text);
  /// @param sentence empty unless the job failed
  void Finished(const QString& title, const QString& sentence, bool cancelled);

 private:
  void StartNext();
  void Look();
  void Finish();

  struct Impl;
  std::unique_ptr<Impl> impl_;
};
