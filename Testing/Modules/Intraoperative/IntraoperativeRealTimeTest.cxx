// At the rate of the video: nothing is waited for, what is shown is said. On the phantom and, where
// it is there, on a recorded study. And the overlay of a given cut beside the true cut.
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkXMLPolyDataReader.h>

#include <cmath>

#include "Adapters/Rendering/VirtualDisplay.h"
#include "GuiScene.h"

using namespace kerf;
using namespace kerf::testing;
namespace fs = std::filesystem;

namespace {

/// Distance from p to a polyline soup of segments, px.
double DistanceTo(const std::vector<std::pair<Vec2, Vec2>>& segments, const Vec2& p) {
  double best = 1e9;
  for (const auto& [a, b] : segments) {
    const Vec2 ab = b - a;
    const double t = std::clamp(ab.dot(p - a) / std::max(ab.squaredNorm(), 1e-12), 0.0, 1.0);
    best = std::min(best, (a + t * ab - p).norm());
  }
  return best;
}

/// The rims of the true cut in the picture of the last frame with truth: edges of its surface
/// between points of the outer surface that have points of the cut's faces as neighbours.
std::vector<std::pair<Vec2, Vec2>> TrueRims(const std::string& study, const CameraModel& camera) {
  const auto read = [](const std::string& path) {
    vtkNew<vtkXMLPolyDataReader> reader;
    reader->SetFileName(path.c_str());
    reader->Update();
    return vtkSmartPointer<vtkPolyData>(reader->GetOutput());
  };
  const auto now = read(study + "/truth/frame_00145_organ.vtp");
  const auto rest = read(study + "/truth/rest_organ.vtp");
  auto* pid = now->GetPointData()->GetArray("pid");
  auto* cut = rest->GetPointData()->GetArray("cut");
  const auto on_face = [&](vtkIdType p) {
    return cut->GetTuple1(vtkIdType(pid->GetTuple1(p))) != 0;
  };
  const auto pixel = [&](vtkIdType p) {
    double x[3];
    now->GetPoint(p, x);  // RAS
    return camera.Project(Vec3(-x[0], -x[1], x[2]));
  };
  std::vector<std::pair<Vec2, Vec2>> rims;
  vtkNew<vtkIdList> corners;
  for (vtkIdType t = 0; t < now->GetNumberOfCells(); ++t) {
    now->GetCellPoints(t, corners);
    std::vector<vtkIdType> outer;
    for (int k = 0; k < 3; ++k)
      if (!on_face(corners->GetId(k))) outer.push_back(corners->GetId(k));
    if (outer.size() == 2) rims.push_back({pixel(outer[0]), pixel(outer[1])});
  }
  return rims;
}

}  // namespace

class IntraoperativeRealTimeTest : public QObject {
  Q_OBJECT

 private:
  void Start(Page* page, const std::string& study, const std::string& case_folder) {
    page->widget->OpenCase(QString::fromStdString(case_folder));
    page->widget->OpenSource(QString::fromStdString(OpenStudy(study).video));
    QTRY_VERIFY_WITH_TIMEOUT(page->widget->Desk().Newest().has_value(), 5000);
    page->widget->StartWithGivenPose();
    QCOMPARE(page->widget->CurrentStep(), qKerfIntraoperativeWidget::Run);
  }
  void RunsInRealTime(const std::string& study, int tetrahedra, double seconds) {
    QTemporaryDir folder;
    const std::string planned =
        PlanStudyCase(study, folder.path().toStdString() + "/case", tetrahedra);
    Page page;
    Start(&page, study, planned);
    QTRY_VERIFY_WITH_TIMEOUT(page.Latest() && page.Latest()->gate == GateState::Green, 10000);
    double registered = 0, shown = 0, latency = 0;
    int count = 0;
    QElapsedTimer clock;
    clock.start();
    while (clock.elapsed() < seconds * 1000) {
      QTest::qWait(250);
      if (clock.elapsed() < 1500) continue;  // of a whole second
      registered += page.Latest()->registered_fps;
      shown += page.widget->ShownPerSecond();
      latency += page.widget->Latency_ms();
      ++count;
    }
    qInfo("%d tetrahedra: registered %.1f/s, shown %.1f/s, latency %.0f ms, dropped %d",
          page.Latest()->tetrahedra, registered / count, shown / count, latency / count,
          page.Latest()->source.dropped);
    QVERIFY(page.Latest()->frame.index > 10);
    QVERIFY(page.Latest()->gate != GateState::Off);
    QVERIFY(page.Find<QLabel>("figures")->text().contains("latency"));
    QVERIFY(page.Find<QLabel>("figures")->text().contains("dropped"));
    QVERIFY(Difference(page.widget->View()->Picture(), ToQImage(*page.Latest()->frame.image)) >
            0.005);
    page.Click("stop");
    QCOMPARE(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Close);
    QVERIFY(page.problems.isEmpty());
  }

 private slots:
  void ThePhantom() { RunsInRealTime(KERF_TEST_PHANTOM, 4000, 4.0); }

  void ARecordedKidney() {
    const std::string study =
        qEnvironmentVariable("KERF_CASES", KERF_CASES_DEFAULT).toStdString() + "/kidney-1";
    if (!fs::exists(study)) QSKIP("no kidney-1 among the cases (KERF_CASES)");
    RunsInRealTime(study, 15000, 6.0);
  }

  /// The true line is drawn before the organ opens; at the end the lips of the overlay are held
  /// against the rims of the true cut.
  void AGivenCutOpensWhereTheTrueOneDoes() {
    const std::string study = KERF_TEST_PHANTOM;
    QTemporaryDir folder;
    const std::string planned = PlanStudyCase(study, folder.path().toStdString() + "/case", 8000);
    Page page;
    CaptureOptions options;
    options.every = true;
    options.paced = false;
    page.widget->Desk().SetCaptureOptions(options);
    page.widget->OpenCase(QString::fromStdString(planned));
    page.widget->OpenSource(QString::fromStdString(study + "/video.mp4"));
    QTRY_VERIFY_WITH_TIMEOUT(page.widget->Desk().Newest().has_value(), 5000);
    page.widget->StartWithGivenPose();
    page.Find<QCheckBox>("hold")->setChecked(true);  // nothing but the given cut
    IntraoperativeDecision given;
    given.kind = IntraoperativeDecision::Kind::DrawCut;
    given.line = ReadCutsFile(study + "/truth/cuts.json").front().polyline_rest;
    given.line.leftCols<2>() *= -1.0;  // the truth is RAS
    QTRY_VERIFY_WITH_TIMEOUT(page.Latest() != nullptr, 10000);
    page.widget->Desk().Post(given);
    QTRY_VERIFY_WITH_TIMEOUT(
        page.Latest() && page.Latest()->source.kind == SourceState::Kind::Ended, 90000);
    QTest::qWait(300);

    const CameraModel camera = page.widget->Desk().Camera();
    const auto rims = TrueRims(study, camera);
    QVERIFY(rims.size() > 10);
    const auto latest = page.Latest();
    QVERIFY(latest->applied_lines.size() == 2);
    std::vector<double> distances;
    for (const Points& lip : latest->applied_lines)
      for (Index i = 0; i < lip.rows(); ++i)
        distances.push_back(DistanceTo(rims, camera.Project(lip.row(i).transpose())));
    std::sort(distances.begin(), distances.end());
    const double median = distances[distances.size() / 2];
    qInfo("lips of the given cut: median %.2f px from the true rims, 90 %% within %.2f px", median,
          distances[distances.size() * 9 / 10]);
    QVERIFY2(median < 3.0, qPrintable(QString::number(median)));
  }
};

int main(int argc, char** argv) {
  std::string why_not;
  if (!RenderingAvailable(&why_not)) {
    std::fprintf(stderr, "no display: %s\n", why_not.c_str());
    return 77;
  }
  qputenv("QT_QPA_PLATFORM", "xcb");
  QApplication app(argc, argv);
  IntraoperativeRealTimeTest test;
  return QTest::qExec(&test, argc, argv);
}

#include "IntraoperativeRealTimeTest.moc"
