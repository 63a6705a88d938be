#pragma once

#include <QDir>
#include <QString>
#include <QTemporaryDir>
#include <QTest>
#include <memory>

#include "Support/TestDisplay.h"

class QApplication;
class QLabel;
class QWidget;
class qKerfMainWindow;

/// Drives the window as a person does: by names of widgets, with mouse and keys.
class GuiDriver {
 public:
  /// @param folder settings and autosaves of this run
  explicit GuiDriver(const QString& folder);
  ~GuiDriver();

  qKerfMainWindow* Window() const { return window_.get(); }
  QWidget* Find(const QString& name) const;
  void Click(const QString& button) const;
  void Undo() const;  ///< by key, when the window has the keyboard: a dialog may just have had it
  QString Text(const QString& label) const;
  QString Message() const;          ///< of the message bar; empty when it is closed
  double Volume_ml(int row) const;  ///< as the label list says
  /// A figure of the plan's table; −1 where it is not there.
  double Measure(const QString& name) const;
  int State(int step) const;  ///< 0 to do, 1 done, 2 problem
  void Step(int step) const;
  /// Drops a path onto the window, as from a file manager.
  void Drop(const QString& path) const;
  /// Waits until no job runs. @return false after the timeout
  bool Idle(int timeout_ms = 60000) const;
  /// Drag with the left button in a slice, in fractions of its size.
  void Drag(const QString& view, double x0, double y0, double x1, double y1) const;
  void ClickAt(const QString& view, double x, double y) const;
  /// A stroke of the brush across the axial slice.
  void Paint() const;
  /// Answers the file dialog that `button` opens.
  void ChooseFile(const QString& button, const QString& path) const;
  /// Where the window that runs in `folder` keeps unsaved work.
  static QDir Unsaved(const QString& folder) { return QDir(folder).filePath("work/planning"); }
  /// Forgets unsaved work without a question, as a crash does.
  void Abandon();

 private:
  std::unique_ptr<qKerfMainWindow> window_;
};

/// The application of a program that drives the window, made before any widget; null where there is
/// no display. @param argc has to outlive it
std::unique_ptr<QApplication> MakeGuiApplication(int& argc, char** argv);

/// main() of a test of the window.
template <class Test>
int RunGuiTest(int argc, char** argv) {
  const auto app = MakeGuiApplication(argc, argv);
  if (!app) return kerf::testing::kNoDisplay;
  Test test;
  return QTest::qExec(&test, argc, argv);
}
