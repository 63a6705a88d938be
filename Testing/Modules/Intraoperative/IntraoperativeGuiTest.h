#pragma once

#include <QTemporaryDir>
#include <memory>
#include <string>

#include "GuiScene.h"

/// The whole way of a session with real mouse and key events, on the phantom: its steps, one after
/// the other, each where the one before has left the window.
class IntraoperativeGuiTest : public QObject {
  Q_OBJECT

 private slots:
  void initTestCase();
  void cleanupTestCase() { page_.reset(); }
  // IntraoperativeGuiTest.cxx: up to the cut.
  void CheckInBlocksTheWrongCaseAndTheWrongCamera();
  void LandmarksOneByOneWithAnOutlierLeftOut();
  void ByHandWithTheOutlineAndUndo();
  void TheCutIsProposedAcceptedRejectedAndUndone();
  void OneKeySwitchesTheOverlayOffAndPresetsChangeIt();
  void TheStripIsReadFromTwoMetres();
  void NothingCoversTheInstruments();
  void ACutIsDrawnByHandAndUndone();
  void ACutTooNearTheTumourRaisesTheAlarm();
  // RecordedSessionGuiTest.cxx: what is left of it.
  void TheSessionIsCompleteExportedAndReplayedBitByBit();
  void TheSessionIsPlayedAgainInTheWindow();
  void ASessionThatDoesNotFitSaysWhere();

 private:
  /// Pictures of the window for whoever looks at them: KERF_GUI_PICTURES names a folder.
  void Keep(const QString& name);

  QTemporaryDir folder_;
  std::string phantom_, case_;
  std::unique_ptr<kerf::testing::Page> page_;
};
