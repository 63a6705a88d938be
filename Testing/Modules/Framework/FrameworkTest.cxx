#include <QElapsedTimer>
#include <QFile>
#include <QSignalSpy>
#include <QTemporaryDir>
#include <QTest>
#include <atomic>
#include <thread>

#include "Core/Errors.h"
#include "Core/Progress.h"
#include "Framework/qKerfJobRunner.h"
#include "Framework/qKerfModule.h"
#include "Framework/qKerfPluginLoader.h"

/// Plugins and jobs: what holds the window together.
class FrameworkTest : public QObject {
  Q_OBJECT
 private slots:
  void FindsPluginsAndSaysWhyNot();
  void MissingFolderIsEmpty();
  void JobRunsOffTheGuiThread();
  void CancelStopsTheJobAndDropsTheQueue();
  void FailureIsASentence();
  void RunnerWaitsForItsWorker();
};

void FrameworkTest::FindsPluginsAndSaysWhyNot() {
  QTemporaryDir broken;
  QFile garbage(broken.filePath("garbage.so"));
  QVERIFY(garbage.open(QIODevice::WriteOnly));
  garbage.write("this is no library");
  garbage.close();
  const qKerfPluginSearch found = FindKerfPlugins({KERF_TEST_PLUGINS, broken.path()});
  QCOMPARE(found.plugins.size(), 1);
  QCOMPARE(found.plugins[0].name, QString("good"));
  QCOMPARE(found.plugins[0].title, QString("Good"));
  QCOMPARE(found.plugins[0].version, QString("1.2.3"));
  QCOMPARE(found.plugins[0].order, 7);
  QCOMPARE(found.plugins[0].module->Name(), QString("good"));
  QCOMPARE(found.refused.size(), 3);
  QString old, nameless, no_plugin;
  for (const auto& r : found.refused) {
    if (r.path.contains("Old")) old = r.why;
    if (r.path.contains("Nameless")) nameless = r.why;
    if (r.path.contains("garbage")) no_plugin = r.why;
  }
  QVERIFY2(old.contains("org.kerf.Module/0"), qPrintable(old));
  QVERIFY2(nameless.contains("no name"), qPrintable(nameless));
  QVERIFY2(no_plugin.contains("no Qt plugin"), qPrintable(no_plugin));
  // A name that is taken is refused as well.
  QCOMPARE(FindKerfPlugins({KERF_TEST_PLUGINS, KERF_TEST_PLUGINS}).plugins.size(), 1);
}

void FrameworkTest::MissingFolderIsEmpty() {
  const qKerfPluginSearch found = FindKerfPlugins({"/nowhere/at/all"});
  QVERIFY(found.plugins.isEmpty());
  QVERIFY(found.refused.isEmpty());
}

void FrameworkTest::JobRunsOffTheGuiThread() {
  qKerfJobRunner runner;
  QSignalSpy progressed(&runner, &qKerfJobRunner::Progressed);
  QSignalSpy warned(&runner, &qKerfJobRunner::Warned);
  const auto gui = std::this_thread::get_id();
  std::thread::id worker, done;
  bool finished = false;
  qKerfJobRunner::Job job;
  job.title = "work";
  job.work = [&](kerf::Progress& progress) {
    worker = std::this_thread::get_id();
    progress.Report(0.5, "half");
    progress.Warn("odd");
    std::this_thread::sleep_for(std::chrono::milliseconds(80));
  };
  job.done = [&] {
    done = std::this_thread::get_id();
    finished = true;
  };
  runner.Run(job);
  QVERIFY(runner.IsBusy());
  QCOMPARE(runner.Title(), QString("work"));
  QTRY_VERIFY(finished);
  QVERIFY(worker != gui);
  QVERIFY(done == gui);
  QVERIFY(!runner.IsBusy());
  QVERIFY(progressed.count() >= 1);
  QCOMPARE(warned.count(), 1);
  QCOMPARE(warned[0][0].toString(), QString("odd"));
}

void FrameworkTest::CancelStopsTheJobAndDropsTheQueue() {
  qKerfJobRunner runner;
  std::atomic<int> started{0};
  bool done = false, cancelled = false;
  qKerfJobRunner::Job job;
  job.work = [&](kerf::Progress& progress) {
    ++started;
    for (;;) {
      progress.ThrowIfCancelled();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  };
  job.done = [&] { done = true; };
  job.cancelled = [&] { cancelled = true; };
  runner.Run(job);
  runner.Run(job);
  QTRY_COMPARE(started.load(), 1);
  runner.Cancel();
  QTRY_VERIFY(cancelled);
  QTest::qWait(100);
  QVERIFY(!done);
  QCOMPARE(started.load(), 1);
  QVERIFY(!runner.IsBusy());
}

void FrameworkTest::FailureIsASentence() {
  qKerfJobRunner runner;
  QString sentence;
  bool next = false;
  qKerfJobRunner::Job bad, good;
  bad.work = [](kerf::Progress&) { throw kerf::InputError("ct.nii", "header", "is too short"); };
  bad.failed = [&](const QString& s) { sentence = s; };
  good.work = [](kerf::Progress&) {};
  good.done = [&] { next = true; };
  runner.Run(bad);
  runner.Run(good);
  QTRY_VERIFY(next);
  QVERIFY2(sentence.contains("ct.nii") && sentence.contains("too short"), qPrintable(sentence));
}

void FrameworkTest::RunnerWaitsForItsWorker() {
  std::atomic<bool> left{false};
  {
    qKerfJobRunner runner;
    qKerfJobRunner::Job job;
    job.work = [&](kerf::Progress& progress) {
      while (!progress.IsCancelled()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      left = true;
    };
    runner.Run(job);
  }
  QVERIFY(left);
}

QTEST_GUILESS_MAIN(FrameworkTest)
#include "FrameworkTest.moc"
