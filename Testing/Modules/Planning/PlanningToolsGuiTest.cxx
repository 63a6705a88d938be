// The tools of planning that need a folder, a dialog or two labels: the list of a DICOM folder's
// series, the import of finished labels, the active contour, booleans, the slices. With real
// events.
#include <QAction>
#include <QApplication>
#include <QComboBox>
#include <QDialog>
#include <QDialogButtonBox>
#include <QDir>
#include <QDoubleSpinBox>
#include <QHeaderView>
#include <QPushButton>
#include <QSlider>
#include <QTableWidget>
#include <QTimer>
#include <QTreeWidget>

#include "Adapters/Itk/VolumeFiles.h"
#include "Application/qKerfApplicationHost.h"
#include "Application/qKerfMainWindow.h"
#include "GuiDriver.h"
#include "Logic/Itk/DicomFiles.h"
#include "SmallCt.h"

using kerf::testing::DicomFile;

class PlanningToolsGuiTest : public QObject {
  Q_OBJECT
 private slots:
  void init();
  void cleanup();
  void TheListOfSeriesTellsThemApart();
  void FinishedLabelsAreImported();
  void TheContourSnapsToTheEdgesAndIsUndone();
  void TheContourIsStopped();
  void LabelsAreCombined();
  void SlicesAreLinked();
  void APointOfTheLineIsMoved();

 private:
  QString Path(const QString& name) const { return folder_.filePath(name); }
  QString UndoText() const {
    return gui_->Window()->findChild<QAction*>("undoAction")->text().remove('&');
  }
  void OpenSmallCt() {
    kerf::WriteVolume(Path("ct.nrrd").toStdString(), kerf::testing::SmallCt());
    gui_->Drop(Path("ct.nrrd"));
    QVERIFY(gui_->Idle());
    gui_->Step(1);
  }
  void SelectLabel(int row) const {
    auto* labels = qobject_cast<QTableWidget*>(gui_->Find("labelList"));
    QTest::mouseClick(labels->viewport(), Qt::LeftButton, {},
                      labels->visualItemRect(labels->item(row, 1)).center());
    QCOMPARE(labels->currentRow(), row);
  }
  /// A press on a button that the panel may have to be scrolled to.
  void Press(const char* name) const { qobject_cast<QAbstractButton*>(gui_->Find(name))->click(); }
  /// The organ by its preset, and a bump painted onto its side.
  void SegmentAndSpoil() {
    gui_->Click("segmentButton");
    QVERIFY(gui_->Idle());
    true_ml_ = gui_->Volume_ml(0);
    gui_->Click("toolPaint");
    Press("sphereCheck");
    gui_->Drag("sliceAxial", 0.86, 0.4, 0.86, 0.6);
    spoiled_ml_ = gui_->Volume_ml(0);
    QVERIFY2(spoiled_ml_ > true_ml_ + 0.5, qPrintable(QString::number(spoiled_ml_ - true_ml_)));
  }

  QTemporaryDir folder_;
  std::unique_ptr<GuiDriver> gui_;
  double true_ml_ = 0, spoiled_ml_ = 0;
};

void PlanningToolsGuiTest::init() {
  QDir(Path("run")).removeRecursively();
  QDir().mkpath(Path("run"));
  gui_ = std::make_unique<GuiDriver>(Path("run"));
}

void PlanningToolsGuiTest::cleanup() { gui_->Abandon(); }

void PlanningToolsGuiTest::TheListOfSeriesTellsThemApart() {
  const QString dicom = Path("dicom");
  QDir().mkpath(dicom);
  for (const bool contrast : {false, true})
    for (int slice = 0; slice < 5; ++slice) {
      DicomFile file(20, 16, 2.0 * slice, contrast ? 100 + slice : slice);
      if (contrast) {
        file.Text(0x0020000e, "UI", "1.2.3.5");
        file.Text(0x0008103e, "LO", "Abdomen venous 2.0");
        file.Text(0x00180010, "LO", "Iomeprol");
        file.Text(0x00181042, "TM", "101500");
        file.Text(0x00080032, "TM", "101610.5");
        file.Text(0x00200060, "CS", "L");
      } else {
        file.Text(0x0008103e, "LO", "Abdomen nativ");
      }
      file.Text(0x00100030, "DA", "19700102");
      file.Write((dicom + QString("/%1-%2.dcm").arg(contrast).arg(slice)).toStdString());
    }
  auto* table = qobject_cast<QTreeWidget*>(gui_->Find("seriesTable"));
  QVERIFY(!table->isVisible());
  gui_->Drop(dicom);
  QVERIFY(gui_->Idle());
  QTRY_VERIFY(table->isVisible());
  QCOMPARE(table->topLevelItemCount(), 2);
  const auto row = [table](int i) {
    QStringList texts;
    for (int c = 0; c < table->columnCount(); ++c) texts << table->topLevelItem(i)->text(c);
    return texts.join("|");
  };
  QCOMPARE(row(0), QString("CT Abdomen nativ|Doe, Jane · P1 · 19700102||native|5|0.75 × 0.5 × 2"));
  QCOMPARE(row(1), QString("CT Abdomen venous 2.0|Doe, Jane · P1 · 19700102|left|venous, 71 s|5|"
                           "0.75 × 0.5 × 2"));
  // Nothing is cut off at 1280 pixels.
  QVERIFY(table->header()->length() <= table->viewport()->width());
  const QString pictures = qEnvironmentVariable("KERF_GUI_PICTURES");
  if (!pictures.isEmpty()) gui_->Window()->grab().save(pictures + "/planning-series.png");
  QTest::mouseClick(table->viewport(), Qt::LeftButton, {},
                    table->visualItemRect(table->topLevelItem(1)).center());
  gui_->Click("openSeriesButton");
  QVERIFY(gui_->Idle());
  QTRY_COMPARE(gui_->State(0), 1);
  QVERIFY(!table->isVisible());
  QVERIFY2(gui_->Text("importInfo").contains("20 × 16 × 5"), qPrintable(gui_->Text("importInfo")));
  QVERIFY2(gui_->Text("importInfo").contains("venous"), qPrintable(gui_->Text("importInfo")));
  // The name was for the eyes of the person who chose: it stays nowhere.
  QVERIFY(!gui_->Text("importInfo").contains("Doe"));
}

void PlanningToolsGuiTest::FinishedLabelsAreImported() {
  OpenSmallCt();
  kerf::LabelMap labels;
  labels.grid = kerf::testing::SmallCt().grid;
  auto voxels = std::make_shared<std::vector<std::uint8_t>>(labels.grid.VoxelCount(), 0);
  for (std::size_t v = 0; v < 10000; ++v) (*voxels)[20000 + v] = v < 1000 ? 7 : v < 9000 ? 5 : 9;
  labels.voxels = voxels;
  const QString file = Path("total.nii.gz");
  kerf::WriteLabelMap(file.toStdString(), labels);
  bool asked = false, may_go_on_without_organ = true;
  // The dialog comes when the file has been read; answered as a person does.
  QTimer answer;
  connect(&answer, &QTimer::timeout, this, [&] {
    auto* dialog = qobject_cast<QDialog*>(QApplication::activeModalWidget());
    if (!dialog || dialog->objectName() != "labelImportDialog") return;
    answer.stop();
    asked = true;
    auto* ok = dialog->findChild<QDialogButtonBox*>()->button(QDialogButtonBox::Ok);
    may_go_on_without_organ = ok->isEnabled();
    dialog->findChild<QComboBox*>("role5")->setCurrentIndex(1);
    dialog->findChild<QComboBox*>("role7")->setCurrentIndex(2);
    const QString pictures = qEnvironmentVariable("KERF_GUI_PICTURES");
    if (!pictures.isEmpty()) dialog->grab().save(pictures + "/planning-labels.png");
    QTest::mouseClick(ok, Qt::LeftButton);
  });
  gui_->ChooseFile("importLabelsButton", file);
  answer.start(50);
  QTRY_VERIFY_WITH_TIMEOUT(asked, 20000);
  QVERIFY(!may_go_on_without_organ);
  QVERIFY(gui_->Idle());
  QTRY_COMPARE(gui_->Volume_ml(0), 64.0);  // 8,000 voxels of 8 mm³
  QCOMPARE(gui_->Volume_ml(1), 8.0);
  QCOMPARE(gui_->Volume_ml(2), 0.0);  // label 9 was left out
  QCOMPARE(UndoText(), QString("Undo: import labels"));
  gui_->Undo();
  QTRY_COMPARE(gui_->Volume_ml(0), 0.0);
}

void PlanningToolsGuiTest::TheContourSnapsToTheEdgesAndIsUndone() {
  OpenSmallCt();
  SegmentAndSpoil();
  const QImage before = gui_->Find("sliceAxial")->grab().toImage();
  Press("evolveButton");
  QVERIFY(gui_->Window()->Host()->Jobs().IsBusy());
  bool seen_moving = false;
  while (gui_->Window()->Host()->Jobs().IsBusy()) {
    QTest::qWait(20);
    seen_moving = seen_moving || gui_->Find("sliceAxial")->grab().toImage() != before;
  }
  QVERIFY(seen_moving);
  QVERIFY(gui_->Idle());
  QTRY_VERIFY2(gui_->Volume_ml(0) < spoiled_ml_ - 0.3, qPrintable(gui_->Message()));
  QCOMPARE(UndoText(), QString("Undo: snap to edges"));
  gui_->Undo();
  QTRY_COMPARE(gui_->Volume_ml(0), spoiled_ml_);
}

void PlanningToolsGuiTest::TheContourIsStopped() {
  OpenSmallCt();
  SegmentAndSpoil();
  Press("evolveButton");
  QTest::keyClick(gui_->Window(), Qt::Key_Escape);
  QVERIFY(gui_->Idle(15000));
  QVERIFY2(gui_->Message().isEmpty(), qPrintable(gui_->Message()));
  // Whatever it had reached is kept as one step, or there was nothing yet.
  QVERIFY(gui_->Volume_ml(0) <= spoiled_ml_ + 0.5);
  QVERIFY(UndoText() == "Undo: snap to edges" || UndoText() == "Undo: paint");
}

void PlanningToolsGuiTest::LabelsAreCombined() {
  OpenSmallCt();
  gui_->Click("toolPaint");
  gui_->Drag("sliceAxial", 0.3, 0.5, 0.5, 0.5);
  SelectLabel(1);
  gui_->Drag("sliceAxial", 0.65, 0.5, 0.75, 0.5);
  const double organ = gui_->Volume_ml(0), tumour = gui_->Volume_ml(1);
  QVERIFY(organ > 0.1 && tumour > 0.1);
  // A label with itself is a sentence.
  Press("booleanButton");
  QVERIFY2(gui_->Message().contains("two different labels"), qPrintable(gui_->Message()));
  // The organ takes the tumour over.
  SelectLabel(0);
  auto* operation = qobject_cast<QComboBox*>(gui_->Find("booleanOperation"));
  auto* reach = qobject_cast<QDoubleSpinBox*>(gui_->Find("booleanReach"));
  qobject_cast<QComboBox*>(gui_->Find("booleanOther"))->setCurrentIndex(1);
  operation->setCurrentIndex(0);
  Press("booleanButton");
  QVERIFY(gui_->Idle());
  QTRY_VERIFY(std::abs(gui_->Volume_ml(0) - (organ + tumour)) < 0.11);
  QCOMPARE(gui_->Volume_ml(1), 0.0);
  QCOMPARE(UndoText(), QString("Undo: combine labels"));
  gui_->Undo();
  QTRY_COMPARE(gui_->Volume_ml(0), organ);
  QCOMPARE(gui_->Volume_ml(1), tumour);
  // Subtract what lies within reach of the tumour: less of the organ, the tumour as it was.
  operation->setCurrentIndex(1);
  reach->setValue(12);
  Press("booleanButton");
  QVERIFY(gui_->Idle());
  QTRY_VERIFY(gui_->Volume_ml(0) < organ);
  const double far_part = gui_->Volume_ml(0);
  QCOMPARE(gui_->Volume_ml(1), tumour);
  gui_->Undo();
  QTRY_COMPARE(gui_->Volume_ml(0), organ);
  // Keep only near: the other part of it.
  operation->setCurrentIndex(2);
  Press("booleanButton");
  QVERIFY(gui_->Idle());
  QTRY_VERIFY(std::abs(gui_->Volume_ml(0) - (organ - far_part)) < 0.11);
}

void PlanningToolsGuiTest::SlicesAreLinked() {
  OpenSmallCt();
  const QImage before = gui_->Find("sliceCoronal")->grab().toImage();
  gui_->ClickAt("sliceAxial", 0.5, 0.3);
  QTest::qWait(50);
  QVERIFY(gui_->Find("sliceCoronal")->grab().toImage() != before);
  const QImage axial = gui_->Find("sliceAxial")->grab().toImage();
  QTest::keyClick(gui_->Find("sliceAxial"), Qt::Key_Up);
  QTest::qWait(50);
  QVERIFY(gui_->Find("sliceAxial")->grab().toImage() != axial);
  // A window preset brightens or darkens the picture.
  const QImage grey = gui_->Find("sliceSagittal")->grab().toImage();
  auto* window = qobject_cast<QComboBox*>(gui_->Find("windowChoice"));
  window->setFocus();
  QTest::keyClick(window, Qt::Key_Down);
  QTest::qWait(50);
  QVERIFY(gui_->Find("sliceSagittal")->grab().toImage() != grey);
}

void PlanningToolsGuiTest::APointOfTheLineIsMoved() {
  OpenSmallCt();
  gui_->Click("segmentButton");
  QVERIFY(gui_->Idle());
  gui_->Step(2);
  qobject_cast<QSlider*>(gui_->Find("tetrahedraSlider"))->setValue(10);
  gui_->Click("meshButton");
  QVERIFY(gui_->Idle());
  gui_->Step(3);
  gui_->Click("lookFromA");
  QTest::qWait(100);
  gui_->Click("drawLineButton");
  gui_->ClickAt("sceneCanvas", 0.4, 0.5);
  gui_->ClickAt("sceneCanvas", 0.6, 0.5);
  QTRY_COMPARE(gui_->Text("lineText"), QString("2 points on the organ"));
  QTest::qWait(300);
  const QImage before = gui_->Find("sceneCanvas")->grab().toImage();
  // A click on a point adds none; a drag moves it, and the picture does not turn.
  gui_->ClickAt("sceneCanvas", 0.6, 0.5);
  gui_->Drag("sceneCanvas", 0.6, 0.5, 0.6, 0.4);
  QCOMPARE(gui_->Text("lineText"), QString("2 points on the organ"));
  QCOMPARE(UndoText(), QString("Undo: move point of the resection line"));
  QTest::qWait(200);
  QVERIFY(gui_->Find("sceneCanvas")->grab().toImage() != before);
  gui_->Undo();
  QTest::qWait(200);
  QVERIFY(gui_->Find("sceneCanvas")->grab().toImage() == before);
}

int main(int argc, char** argv) { return RunGuiTest<PlanningToolsGuiTest>(argc, argv); }

#include "PlanningToolsGuiTest.moc"
