// A given cut in the window: its picture against a golden one, what opacity changes, what a
// snapshot keeps, and what the exported files hold when they are read back.
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/JournalRead.h"
#include "GuiScene.h"
#include "Session/TableTracker.h"
#include "Support/ImageSimilarity.h"

using namespace kerf;
using namespace kerf::testing;
namespace fs = std::filesystem;

namespace {

const QRect kAroundCut(350, 180, 320, 260);  ///< px, without the overlay's words

std::string Content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

double Volume_mm3(const TetMesh& mesh) {
  double sum = 0;
  for (Index t = 0; t < mesh.TetCount(); ++t) sum += TetVolume(mesh.rest, mesh.tets, t);
  return sum;
}

/// Of the points of two surfaces, in order; a kilometre where they are not as many.
double Apart_mm(const Points& a, const Points& b) {
  if (a.rows() != b.rows() || a.rows() == 0) return 1e6;
  return (a - b).rowwise().norm().maxCoeff();
}

/// True tracks that stay where they end: decisions after the last picture let the model settle.
class LastingTracks : public TableTracker {
 public:
  using TableTracker::TableTracker;
  void Track(const Frame& frame, FeatureSet* features) override {
    Frame there = frame;
    there.index = std::min(frame.index, FrameCount() - 1);
    TableTracker::Track(there, features);
  }
};

}  // namespace

class CutPictureGuiTest : public QObject {
  Q_OBJECT

 private slots:
  void initTestCase();
  void cleanupTestCase() { page_.reset(); }
  void TheCutLooksAsItDid();
  void OpacityChangesTheOrganAlone();
  void ASnapshotIsThePictureThatIsShown();
  void TheFilesHoldTheCutModel();

 private:
  QImage Picture() { return page_->widget->View()->Picture().copy(); }
  /// Confirms the registration where that is asked for.
  bool ShowsOverlay() {
    return QTest::qWaitFor(
        [&] {
          if (page_->Latest()->needs_confirmation) page_->Key(Qt::Key_C);
          return page_->Latest()->gate != GateState::Off;
        },
        10000);
  }
  QImage Raw() { return ToQImage(*page_->Latest()->frame.image); }

  QTemporaryDir folder_;
  std::string case_;
  std::vector<std::string> snapshots_;
  Points line_;  ///< of the cut, at rest, LPS
  std::unique_ptr<Page> page_;
};

/// The phantom by its true tracks, its true cut given in the first frame, up to the last.
void CutPictureGuiTest::initTestCase() {
  const std::string phantom = KERF_TEST_PHANTOM;
  case_ = PlanStudyCase(phantom, folder_.path().toStdString() + "/case", 6000);
  const auto truth = nlohmann::json::parse(std::ifstream(phantom + "/truth/cuts.json"))["cuts"][0];
  const auto& line = truth["polyline_rest"];
  line_.resize(line.size(), 3);
  for (std::size_t i = 0; i < line.size(); ++i)
    line_.row(i) << -line[i][0].get<double>(), -line[i][1].get<double>(), line[i][2].get<double>();

  page_ = std::make_unique<Page>();
  CaptureOptions options;
  options.every = true;
  options.paced = false;
  IntraoperativeDesk& desk = page_->widget->Desk();
  desk.SetCaptureOptions(options);
  desk.SetTrackerMaker([phantom] {
    return std::make_unique<LastingTracks>(
        ReadTracks(phantom + "/features_2d.csv", phantom + "/features_rest.csv"));
  });
  page_->widget->OpenCase(QString::fromStdString(case_));
  page_->widget->OpenSource(QString::fromStdString(phantom + "/video.mp4"));
  QTRY_VERIFY_WITH_TIMEOUT(desk.Newest().has_value(), 10000);
  page_->Find<QCheckBox>("hold")->setChecked(true);  // the given cut alone
  page_->widget->SetDeadline(0);                     // the same picture on every machine
  IntraoperativeDecision given;
  given.kind = IntraoperativeDecision::Kind::DrawCut;
  given.line = line_;
  desk.GiveCuts({given});
  page_->widget->StartWithGivenPose();
  QTRY_VERIFY_WITH_TIMEOUT(page_->Latest(), 10000);
  QTRY_VERIFY_WITH_TIMEOUT(desk.Source().kind == SourceState::Kind::Ended, 110000);
  QTRY_VERIFY_WITH_TIMEOUT(page_->Latest()->frame.index + 1 == desk.Source().delivered, 10000);
  QTRY_VERIFY_WITH_TIMEOUT(page_->Latest()->source.kind == SourceState::Kind::Ended, 10000);
  QVERIFY(page_->Latest()->cuts.size() >= 1 && page_->Latest()->cuts[0].drawn);
  QVERIFY(ShowsOverlay());
}

void CutPictureGuiTest::TheCutLooksAsItDid() {
  QTRY_VERIFY_WITH_TIMEOUT(page_->widget->Shown() == page_->Latest(), 10000);
  if (const QString pictures = qEnvironmentVariable("KERF_GUI_PICTURES"); !pictures.isEmpty())
    page_->widget->grab().save(pictures + "/intraoperative-given-cut.png");
  const QString golden = QString(KERF_BASELINES) + "/Intraoperative/given-cut.jpg";
  if (qEnvironmentVariableIsSet("KERF_WRITE_BASELINES"))
    Picture().copy(kAroundCut).save(golden, nullptr, 88);
  const QImage expected = QImage(golden).convertToFormat(QImage::Format_BGR888);
  QVERIFY2(!expected.isNull(), qPrintable(golden));
  const auto similar = [&](const QRect& part) {
    return StructuralSimilarity(FromQImage(Picture().copy(part)), FromQImage(expected));
  };
  QTRY_VERIFY2_WITH_TIMEOUT(similar(kAroundCut) > 0.9,
                            qPrintable(QString::number(similar(kAroundCut))), 10000);
  const double with = similar(kAroundCut), moved = similar(kAroundCut.translated(5, 0));
  // Neither the same moved by 5 px nor the model without the cut passes.
  QVERIFY2(moved < 0.8, qPrintable(QString::number(moved)));
  page_->Key(Qt::Key_R);
  QTRY_VERIFY(page_->Latest()->cuts[0].state == CutItem::State::Rejected);
  QTRY_VERIFY2_WITH_TIMEOUT(similar(kAroundCut) < 0.8,
                            qPrintable(QString::number(similar(kAroundCut))), 10000);
  qInfo("structural similarity %.3f, moved by 5 px %.3f, without the cut %.3f", with, moved,
        similar(kAroundCut));
  page_->Key(Qt::Key_Z);
  QTRY_VERIFY(page_->Latest()->cuts[0].state == CutItem::State::Applied);
  QVERIFY(ShowsOverlay());  // it goes while the model does not fit
  QTRY_VERIFY_WITH_TIMEOUT(similar(kAroundCut) > 0.9, 10000);
}

void CutPictureGuiTest::OpacityChangesTheOrganAlone() {
  auto* slider = page_->Find<QSlider>("opacity");
  const QRect corner(700, 440, 120, 60);  // nothing lies over the picture there
  const auto share = [&] { return Difference(Picture(), Raw()); };
  // The denser, the farther from what the camera sees.
  const double usual = share();
  slider->setValue(5);
  QTRY_VERIFY2_WITH_TIMEOUT(share() < usual, qPrintable(QString::number(share())), 10000);
  slider->setValue(95);
  QTRY_VERIFY2_WITH_TIMEOUT(share() > usual + 0.05, qPrintable(QString::number(share())), 10000);
  QCOMPARE(Difference(Picture().copy(corner), Raw().copy(corner)), 0.0);
  slider->setValue(30);
  QTRY_VERIFY2_WITH_TIMEOUT(std::abs(share() - usual) < 0.01, qPrintable(QString::number(share())),
                            10000);
}

void CutPictureGuiTest::ASnapshotIsThePictureThatIsShown() {
  // The second of the same frame stands beside the first.
  const auto file = [&](const char* which) {
    char name[32];
    std::snprintf(name, sizeof name, "frame_%06d%s.png", page_->widget->Shown()->frame.index,
                  which);
    return fs::path(page_->widget->Desk().SessionPath()) / "snapshots" / name;
  };
  const auto kept = [&](const char* which) {
    return QImage(QString::fromStdString(file(which).string()))
        .convertToFormat(QImage::Format_RGB32);
  };
  const QImage shown = Picture().convertToFormat(QImage::Format_RGB32);
  page_->Click("snapshot");
  QVERIFY2(fs::exists(file("")), file("").c_str());
  QVERIFY(kept("") == shown);
  QVERIFY(Difference(kept(""), Raw()) > 0.01);  // with the overlay, not the bare picture
  page_->Key(Qt::Key_O);
  QTRY_COMPARE(Difference(Picture(), Raw()), 0.0);
  page_->Click("snapshot");
  QCOMPARE(Difference(kept("-2"), Raw()), 0.0);
  QVERIFY(kept("") == shown);
  page_->Key(Qt::Key_O);
  QTRY_VERIFY_WITH_TIMEOUT(Difference(Picture(), Raw()) > 0.01, 10000);
  snapshots_ = {file("").filename().string(), file("-2").filename().string()};
}

void CutPictureGuiTest::TheFilesHoldTheCutModel() {
  const auto last = page_->Latest();
  page_->Click("stop");
  QTRY_COMPARE_WITH_TIMEOUT(page_->widget->CurrentStep(), qKerfIntraoperativeWidget::Close, 10000);
  const fs::path session = page_->widget->Desk().SessionPath();
  std::vector<std::string> snapshots;
  for (const JournalEntry& entry : ReadJournal((session / "journal.jsonl").string()))
    if (entry.event == "snapshot") snapshots.push_back(*entry.Text("file"));
  QVERIFY(snapshots == snapshots_);
  const auto kept = fs::directory_iterator(session / "snapshots");
  QCOMPARE(std::distance(begin(kept), end(kept)), std::ptrdiff_t(2));
  QVERIFY(page_->Exports());

  const TetMesh planned = page_->widget->Desk().Planned().mesh;
  const double planned_mm2 = BoundarySurface(planned, planned.rest).Area();
  for (const char* space : {"lps", "ras"}) {
    const fs::path folder = session / "export" / space;
    const double turned = space[0] == 'r' ? -1.0 : 1.0;
    const Space tagged = space[0] == 'r' ? Space::RAS : Space::LPS;

    // The tetrahedra: the organ's volume, and both faces of the cut in its boundary.
    Points positions;
    const std::string vtu = (folder / "organ_final.vtu").string();
    const TetMesh mesh = ReadTetMesh(vtu, &positions);
    QCOMPARE(int(mesh.TetCount()), last->tetrahedra);
    QVERIFY(std::abs(Volume_mm3(mesh) / Volume_mm3(planned) - 1.0) < 1e-4);
    const double mm2 = BoundarySurface(mesh, mesh.rest).Area();
    QVERIFY2(mm2 > planned_mm2 + 2 * 500, qPrintable(QString::number(mm2 - planned_mm2)));
    const SurfaceMesh boundary = BoundarySurface(mesh, positions);
    QVERIFY(Apart_mm(boundary.points, last->organ.points) < 1e-3);
    vtkNew<vtkXMLUnstructuredGridReader> reader;  // as the file has it
    reader->SetFileName(vtu.c_str());
    reader->Update();
    double point[3];
    reader->GetOutput()->GetPoints()->GetPoint(0, point);
    QVERIFY((Vec3(turned * point[0], turned * point[1], point[2]) - positions.row(0).transpose())
                .norm() < 1e-3);

    // The surfaces, in every format that is read: as shown last, and tagged with their space.
    for (const char* format : {"vtp", "stl", "ply", "obj"}) {
      const auto read = [&](const char* name) {
        const auto file = ReadSurfaceFile((folder / (std::string(name) + "." + format)).string());
        if (file.space != tagged) qWarning("%s: another space", name);
        return file.space == tagged ? file.surface : SurfaceMesh();
      };
      const SurfaceMesh organ = read("organ_final");
      QCOMPARE(organ.triangles.rows(), last->organ.triangles.rows());
      QVERIFY2(std::abs(organ.SignedVolume() / last->organ.SignedVolume() - 1.0) < 1e-4, format);
      QVERIFY2(std::abs(organ.Area() / last->organ.Area() - 1.0) < 1e-4, format);
      QVERIFY2((organ.points.colwise().maxCoeff() - last->organ.points.colwise().maxCoeff())
                       .cwiseAbs()
                       .maxCoeff() < 1e-3,
               format);
      QVERIFY(!last->structures.empty());
      for (const auto& part : last->structures) {
        const SurfaceMesh surface = read((part.name + "_final").c_str());
        QVERIFY2(std::abs(surface.Area() / part.surface.Area() - 1.0) < 1e-3, format);
      }
      // The separation surface passes through the given line.
      const SurfaceMesh cut = read("cut_0_surface");
      QVERIFY2(cut.Area() > 500, format);
      const SurfaceTree tree(cut);
      for (Index i = 0; i < line_.rows(); ++i) {
        const Vec3 p = line_.row(i).transpose();
        QVERIFY2((tree.Closest(p).point - p).norm() < 1.0, format);
      }
    }
    for (const char* name : {"organ_final.glb", "tumour_final.glb", "cut_0_surface.glb"}) {
      const std::string glb = Content(folder / name);  // magic, version, length
      QVERIFY2(glb.rfind("glTF", 0) == 0, name);
      std::uint32_t length = 0;
      std::memcpy(&length, glb.data() + 8, 4);
      QCOMPARE(std::size_t(length), glb.size());
    }
    // The labels: as deformed, on the grid of the CT.
    fs::path labels;
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().extension() == ".nrrd") labels = entry.path();
    const LabelMap now = ReadSegmentation(labels.string());
    const LabelMap then = ReadSegmentation(case_ + "/segmentation.seg.nrrd");
    QVERIFY((now.grid.size - then.grid.size).minCoeff() >= 0);
    QVERIFY((now.grid.spacing_mm - then.grid.spacing_mm).norm() < 1e-6);
    const Vec3 steps = now.grid.IndexFromWorld(then.grid.origin_mm);  // whole ones
    QVERIFY((steps - Vec3(steps.array().round())).norm() < 1e-3);
    QVERIFY(Content(labels).substr(0, 2000).find(
                space[0] == 'r' ? "space: right-anterior-superior"
                                : "space: left-posterior-superior") != std::string::npos);
    double mm3 = 0;
    for (const Label label : {Label::Organ, Label::Tumour, Label::Internal}) {
      QVERIFY2(now.LabelVolume_mm3(label) > 500, qPrintable(QString::number(int(label))));
      mm3 += now.LabelVolume_mm3(label);
    }
    QVERIFY2(std::abs(mm3 / last->organ.SignedVolume() - 1.0) < 0.02,
             qPrintable(QString("%1 %2").arg(mm3).arg(last->organ.SignedVolume())));
  }
  QVERIFY2(page_->problems.isEmpty(), qPrintable(page_->problems.join("\n")));
}

int main(int argc, char** argv) { return RunGuiTest<CutPictureGuiTest>(argc, argv); }

#include "CutPictureGuiTest.moc"
