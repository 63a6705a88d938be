// Sources through the page: a folder of pictures, and one that repeats its picture, with what the
// lamp says of it.
#include <QColor>
#include <filesystem>
#include <thread>

#include "Adapters/OpenCv/VideoSource.h"
#include "Adapters/Rendering/ImageEncoding.h"
#include "GuiScene.h"
#include "Pipelines/SessionFolder.h"

using namespace kerf;
using namespace kerf::testing;
namespace fs = std::filesystem;

namespace {

constexpr int kPictures = 20;

/// The phantom's first pictures, then the last of them again and again for as long as it is asked.
class StandingSource : public FrameSource {
 public:
  StandingSource() : video_(OpenVideo(std::string(KERF_TEST_PHANTOM) + "/video.mp4")) {}
  std::optional<Frame> Next() override {
    if (given_ < kPictures) last_ = video_->Next();
    if (given_ >= kPictures) std::this_thread::sleep_for(std::chrono::milliseconds(40));
    Frame frame = *last_;
    frame.index = given_++;
    return frame;
  }
  int Width() const override { return video_->Width(); }
  int Height() const override { return video_->Height(); }
  double FramesPerSecond() const override { return 25; }
  int FrameCount() const override { return 1 << 20; }

 private:
  std::unique_ptr<FrameSource> video_;
  std::optional<Frame> last_;
  int given_ = 0;
};

/// Share of a label's pixels that are of about this colour.
double ShareOf(QLabel* label, const QColor& colour) {
  const QImage picture = label->grab().toImage();
  int same = 0;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const QColor c = picture.pixelColor(x, y);
      same += std::abs(c.red() - colour.red()) + std::abs(c.green() - colour.green()) +
                  std::abs(c.blue() - colour.blue()) <
              24;
    }
  return double(same) / (picture.width() * picture.height());
}

}  // namespace

class SourceGuiTest : public QObject {
  Q_OBJECT

 private slots:
  void initTestCase() {
    case_ = QString::fromStdString(
        PlanStudyCase(KERF_TEST_PHANTOM, folder_.path().toStdString() + "/case", 4000));
  }
  void AFolderOfPicturesIsASource_data();
  void AFolderOfPicturesIsASource();
  void APictureThatStandsStillIsAmberAndTheTumourHasItsBound();

 private:
  QTemporaryDir folder_;
  QString case_;
};

void SourceGuiTest::AFolderOfPicturesIsASource_data() {
  QTest::addColumn<QString>("source");
  QTest::newRow("folder") << folder_.filePath("pictures");
  QTest::newRow("pattern") << folder_.filePath("pictures/%05d.png");
  const auto video = OpenVideo(std::string(KERF_TEST_PHANTOM) + "/video.mp4");
  fs::create_directories(folder_.filePath("pictures").toStdString());
  for (int i = 0; i < kPictures; ++i) {
    const QString name = QString("pictures/%1.png").arg(i, 5, 10, QLatin1Char('0'));
    WritePng(folder_.filePath(name).toStdString(), *video->Next()->image, 1);
  }
}

void SourceGuiTest::AFolderOfPicturesIsASource() {
  QFETCH(QString, source);
  Page page;
  CaptureOptions options;
  options.every = true;
  options.paced = false;
  page.widget->Desk().SetCaptureOptions(options);
  page.widget->OpenCase(case_);
  page.Type("confirmed", QString::fromStdString(page.widget->Desk().Pseudonym()));
  page.Type("source", folder_.filePath("no-such-folder"), true);
  QTRY_VERIFY2_WITH_TIMEOUT(page.ChecksText().contains("no such file"),
                            qPrintable(page.ChecksText()), 10000);
  QVERIFY2(!page.Find<QPushButton>("register")->isEnabled(), qPrintable(page.ChecksText()));
  page.Type("source", source, true);
  QTRY_VERIFY2_WITH_TIMEOUT(page.Find<QPushButton>("register")->isEnabled(),
                            qPrintable(page.ChecksText()), 20000);
  QVERIFY2(page.ChecksText().contains("960×540"), qPrintable(page.ChecksText()));
  page.Click("register");
  page.Click("given");
  page.Click("accept_registration");
  QCOMPARE(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Run);
  QTRY_VERIFY_WITH_TIMEOUT(page.Latest() && page.Latest()->source.kind == SourceState::Kind::Ended,
                           30000);
  QTRY_COMPARE(page.Latest()->frame.index, kPictures - 1);
  QVERIFY(page.Latest()->gate != GateState::Off);
  page.Key(Qt::Key_O);  // the last picture, bit for bit
  const QImage last(
      folder_.filePath(QString("pictures/%1.png").arg(kPictures - 1, 5, 10, QLatin1Char('0'))));
  QTRY_COMPARE(Difference(page.widget->View()->Picture(), last), 0.0);
  page.Click("stop");
  QTRY_COMPARE_WITH_TIMEOUT(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Close, 20000);
  const fs::path session = page.widget->Desk().SessionPath();
  QCOMPARE(int(ReadRecordedFrames(session.string()).size()), kPictures);
  QVERIFY(ReadSession(session.string()).finished);
  QVERIFY2(page.problems.isEmpty(), qPrintable(page.problems.join("\n")));
  fs::remove_all(session);
}

void SourceGuiTest::APictureThatStandsStillIsAmberAndTheTumourHasItsBound() {
  Page page;
  CaptureOptions options;
  options.every = true;
  page.widget->Desk().SetSourceOpener(
      [](const std::string&) { return std::make_unique<StandingSource>(); }, options);
  page.widget->OpenCase(case_);
  page.widget->OpenSource("pictures");
  QTRY_VERIFY_WITH_TIMEOUT(page.widget->Desk().Newest().has_value(), 20000);
  page.widget->StartWithGivenPose();
  QCOMPARE(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Run);
  auto* lamp = page.Find<QLabel>("lamp");
  const QColor green("#1f7a3d"), amber("#ffbe3c");
  const auto bound = [&] {  // as the page writes that of what it shows
    const double mm = page.widget->Shown()->reliability.tumour_u95_mm;
    return mm > 0 && lamp->text().endsWith(QString("tumour ± %1 mm").arg(mm, 0, 'f', 1));
  };
  QTRY_VERIFY2_WITH_TIMEOUT(lamp->text().startsWith("OVERLAY OK"), qPrintable(lamp->text()), 20000);
  QVERIFY2(bound(), qPrintable(lamp->text()));
  QVERIFY(ShareOf(lamp, green) > 0.5);
  QVERIFY(ShareOf(lamp, amber) < 0.01);
  // The picture is the same bit for bit for half a second: in doubt, the overlay stays.
  QTRY_VERIFY2_WITH_TIMEOUT(lamp->text().startsWith("CAUTION: the picture stands still"),
                            qPrintable(lamp->text()), 20000);
  QVERIFY2(bound(), qPrintable(lamp->text()));
  QVERIFY(ShareOf(lamp, amber) > 0.5);
  QVERIFY(ShareOf(lamp, green) < 0.01);
  QVERIFY(Difference(page.widget->View()->Picture(), ToQImage(*page.Latest()->frame.image)) > 0.01);
  if (const QString pictures = qEnvironmentVariable("KERF_GUI_PICTURES"); !pictures.isEmpty())
    page.widget->grab().save(pictures + "/intraoperative-amber.png");
  QVERIFY2(page.problems.isEmpty(), qPrintable(page.problems.join("\n")));
}

int main(int argc, char** argv) { return RunGuiTest<SourceGuiTest>(argc, argv); }

#include "SourceGuiTest.moc"
