// A real disk that runs full under a session, at its start or in the middle: what is said, what
// goes on, what is left and how it is taken up again. With real events.
#include <QProcess>
#include <algorithm>

#include "Adapters/OpenCv/ImageSequence.h"
#include "Adapters/OpenCv/VideoSource.h"
#include "Adapters/Rendering/ImageEncoding.h"
#include "CaseIO/JournalRead.h"
#include "GuiScene.h"
#include "SmallDisk.h"

using namespace kerf;
using namespace kerf::testing;
namespace fs = std::filesystem;

namespace {

constexpr int kDisk_MB = 48;
constexpr long kMegabyte = 1 << 20;
constexpr char kDiskAt[] = "KERF_TEST_SMALL_DISK";
constexpr char kReason[] = "No space left on device";
QString disk_folder;  // where it is mounted

int LinesOf(const fs::path& file) {
  std::ifstream in(file);
  int whole = 0;
  for (std::string line; std::getline(in, line) && !in.eof();) ++whole;
  return whole;
}

/// What `kerf replay` makes of a session, in a folder beside the disk. @return its exit status
int ReplaySessionInto(const QString& session, const QString& results) {
  QProcess kerf;
  auto environment = QProcessEnvironment::systemEnvironment();
  environment.remove("DISPLAY");  // this process's own
  kerf.setProcessEnvironment(environment);
  kerf.setProcessChannelMode(QProcess::ForwardedErrorChannel);
  kerf.start(KERF_TEST_PROGRAM, {"replay", session, "--output", results, "--quiet"});
  return kerf.waitForFinished(120000) ? kerf.exitCode() : -1;
}

/// In how many frames a replay came to the same bits as the session: `kerf replay` tells.
int SameBits(const QString& results) {
  for (const JournalEntry& entry : ReadJournal((results + "/journal.jsonl").toStdString()))
    if (entry.event == "end") return int(entry.Number("checksums equal").value_or(-1));
  return -1;
}

}  // namespace

class FullDiskGuiTest : public QObject {
  Q_OBJECT

 private slots:
  void initTestCase();
  void init() { fs::remove_all(case_.toStdString() + "/sessions"); }
  void PicturesFillTheDisk();
  void OthersFillTheDiskUnderAVideo();
  void TheDiskIsFullFromTheStart();

 private:
  /// The next start: the session is offered and taken up.
  void IsTakenUpAgain(const QString& session, const QString& pictures, std::size_t cuts);

  QTemporaryDir folder_;
  QString case_, video_, pictures_;
};

void FullDiskGuiTest::initTestCase() {
  case_ = QString::fromStdString(
      PlanStudyCase(KERF_TEST_PHANTOM, disk_folder.toStdString() + "/case", 3000));
  // On the same disk: a video file is linked, not copied.
  video_ = disk_folder + "/video.mp4";
  fs::copy_file(std::string(KERF_TEST_PHANTOM) + "/video.mp4", video_.toStdString());
  // As from a frame grabber, elsewhere: these are kept one by one.
  pictures_ = folder_.path() + "/pictures";
  fs::create_directories(pictures_.toStdString());
  const auto video = OpenVideo(video_.toStdString());
  for (int i = 0; i < 60; ++i)
    WritePng(QString("%1/%2.png").arg(pictures_).arg(i, 4, 10, QChar('0')).toStdString(),
             *video->Next()->image, 1);
}

void FullDiskGuiTest::IsTakenUpAgain(const QString& session, const QString& pictures,
                                     std::size_t cuts) {
  Page page;
  page.UseEveryFrame();
  page.widget->OpenCase(case_);
  auto* resume = page.Find<QPushButton>("resume");
  QVERIFY(resume->isVisible());
  QVERIFY2(resume->text().contains(QFileInfo(session).fileName()), qPrintable(resume->text()));
  QVERIFY(page.TakeUpAgain(pictures));
  QTRY_VERIFY_WITH_TIMEOUT(page.Latest() && page.Latest()->frame.index >= 2, 30000);
  QVERIFY(page.Latest()->cuts.size() >= cuts);
  for (std::size_t i = 0; i < cuts; ++i) QVERIFY(page.Latest()->cuts[i].drawn);
  QVERIFY(page.Latest()->recording);
  page.Click("stop");
  QTRY_COMPARE_WITH_TIMEOUT(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Close, 30000);
  QVERIFY(ReadSession(page.widget->Desk().SessionPath()).finished);
  QVERIFY2(page.problems.isEmpty(), qPrintable(page.problems.join("\n")));
}

void FullDiskGuiTest::PicturesFillTheDisk() {
  SmallDisk disk(disk_folder.toStdString());
  disk.FillUpTo(4 * kMegabyte);
  QString session;
  int recorded = 0;
  {
    Page page;
    QVERIFY(page.BeginSession(case_, pictures_));
    session = QString::fromStdString(page.widget->Desk().SessionPath());
    QTRY_VERIFY_WITH_TIMEOUT(page.Latest() && !page.Latest()->recording_problem.empty(), 30000);
    const int then = page.Latest()->frame.index;
    // What is said, where: the file and the system's reason, once; and beside the picture.
    QTRY_VERIFY(page.TextOf("recording").contains("Recording has stopped"));
    const QString said = page.TextOf("recording");
    // A picture, or a line of a table where that took what was left.
    QVERIFY2(said.contains(session + "/") && said.contains(kReason), qPrintable(said));
    QTRY_VERIFY(page.TextOf("figures").contains("NOT RECORDED"));
    QCOMPARE(page.problems.size(), 1);
    QVERIFY2(page.problems[0].contains(session) && page.problems[0].contains(kReason),
             qPrintable(page.problems[0]));
    // Also where the picture stands alone.
    page.Key(Qt::Key_F);
    QTRY_VERIFY(!page.Find<QLabel>("recording")->isVisible());
    QVERIFY(page.Find<QLabel>("figures")->isVisible());
    page.Key(Qt::Key_F);
    // Registration and overlay go on.
    QTRY_VERIFY_WITH_TIMEOUT(page.Latest()->frame.index >= then + 10, 30000);
    QTRY_VERIFY_WITH_TIMEOUT(page.Latest()->source.kind == SourceState::Kind::Ended, 60000);
    QVERIFY(page.Latest()->gate != GateState::Off);
    const QRect middle(150, 120, 660, 330);  // without the overlay's words
    QTRY_VERIFY(page.widget->Shown() == page.Latest());
    QVERIFY(Difference(page.widget->View()->Picture().copy(middle),
                       ToQImage(*page.Latest()->frame.image).copy(middle)) > 0.01);
    QCOMPARE(page.problems.size(), 1);
    page.problems.clear();
    // A snapshot that cannot be kept is said, and half a picture is none.
    page.Key(Qt::Key_S);
    QTRY_COMPARE(page.problems.size(), 1);
    QVERIFY2(page.problems[0].contains("snapshots") && page.problems[0].contains(kReason),
             qPrintable(page.problems[0]));
    const fs::path snapshots = (session + "/snapshots").toStdString();
    QVERIFY(!fs::exists(snapshots) || fs::is_empty(snapshots));
    page.Click("stop");
    QTRY_COMPARE_WITH_TIMEOUT(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Close, 30000);
    const QString end = page.TextOf("close_text");
    QVERIFY2(end.contains("ended early") && end.contains(kReason), qPrintable(end));
    // What is there is played in the window, on the full disk.
    page.problems.clear();
    page.Click("play_session");
    QCOMPARE(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Review);
    QTRY_VERIFY_WITH_TIMEOUT(page.widget->Shown() != nullptr, 30000);
    QVERIFY2(page.problems.isEmpty(), qPrintable(page.problems.join("\n")));
  }
  // Every picture is whole, and there is none but those listed and one whose line found no room.
  const auto frames = ReadRecordedFrames(session.toStdString());
  recorded = int(frames.size());
  QVERIFY2(recorded > 10 && recorded < 60, qPrintable(QString::number(recorded)));
  int pictures = 0;
  for (const auto& entry : fs::directory_iterator((session + "/frames").toStdString())) {
    QVERIFY2(ReadImageFile(entry.path().string()), entry.path().c_str());
    ++pictures;
  }
  QVERIFY2(pictures == recorded || pictures == recorded + 1, qPrintable(QString::number(pictures)));
  const int states = LinesOf((session + "/states.csv").toStdString()) - 1;
  QVERIFY2(states > 10 && states <= recorded, qPrintable(QString::number(states)));
  QVERIFY(!ReadJournal((session + "/journal.jsonl").toStdString()).empty());
  QVERIFY(!ReadSession(session.toStdString()).finished);

  const QString results = folder_.path() + "/replayed-pictures";
  const int status = ReplaySessionInto(session, results);
  QVERIFY2(status == 0, qPrintable(QString::number(status)));
  QCOMPARE(SameBits(results), states);
  const auto overlay = OpenVideo(results.toStdString() + "/overlay.mp4");
  int shown = 0;
  while (overlay->Next()) ++shown;
  QCOMPARE(shown, recorded);
  disk.Free();
  IsTakenUpAgain(session, pictures_, 0);
}

void FullDiskGuiTest::OthersFillTheDiskUnderAVideo() {
  SmallDisk disk(disk_folder.toStdString());
  QString session;
  {
    Page page;
    QVERIFY(page.BeginSession(case_, video_));
    session = QString::fromStdString(page.widget->Desk().SessionPath());
    page.Find<QCheckBox>("hold")->setChecked(true);
    QTRY_VERIFY_WITH_TIMEOUT(page.Latest(), 30000);
    page.Key(Qt::Key_D);
    page.Drag({330, 340}, {330, 200});
    const auto drawn = [&] {
      const auto& cuts = page.Latest()->cuts;
      return std::any_of(cuts.begin(), cuts.end(), [](const CutItem& cut) { return cut.drawn; });
    };
    QTRY_VERIFY_WITH_TIMEOUT(drawn(), 30000);
    disk.FillUpTo(0);
    const int then = page.Latest()->frame.index;
    QTRY_VERIFY_WITH_TIMEOUT(!page.Latest()->recording_problem.empty(), 60000);
    QTRY_VERIFY2(page.TextOf("recording").contains(kReason), qPrintable(page.TextOf("recording")));
    QVERIFY2(page.TextOf("recording").contains(session), qPrintable(page.TextOf("recording")));
    QTRY_VERIFY_WITH_TIMEOUT(page.Latest()->source.kind == SourceState::Kind::Ended, 60000);
    QVERIFY(page.Latest()->frame.index > then);
    QVERIFY(page.Latest()->stopped.empty());
    page.Click("stop");
    QTRY_COMPARE_WITH_TIMEOUT(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Close, 30000);
  }
  const fs::path at = session.toStdString();
  QVERIFY(ReadRecordedFrames(at.string()).size() > 10);
  QVERIFY(!ReadJournal((at / "journal.jsonl").string()).empty());
  for (const auto& entry : fs::directory_iterator(at))
    QVERIFY2(entry.path().filename().string().find("partial") == std::string::npos,
             entry.path().c_str());
  // All of the video is there, and what was registered is done again with the same bits.
  QCOMPARE(fs::file_size(at / "video.mp4"), fs::file_size(video_.toStdString()));
  const QString results = folder_.path() + "/replayed-video";
  QCOMPARE(ReplaySessionInto(session, results), 0);
  const int states = LinesOf(at / "states.csv") - 1;
  QVERIFY2(states > 10, qPrintable(QString::number(states)));
  QCOMPARE(SameBits(results), states);
  disk.Free();
  IsTakenUpAgain(session, video_, 1);
}

void FullDiskGuiTest::TheDiskIsFullFromTheStart() {
  SmallDisk disk(disk_folder.toStdString());
  // A picture's worth is left, and a video from elsewhere has to be copied: or nothing is left.
  const QString elsewhere = QString(KERF_TEST_PHANTOM) + "/video.mp4";
  for (const auto& [pictures, left] :
       {qMakePair(elsewhere, long(fs::file_size(elsewhere.toStdString())) / 2),
        qMakePair(pictures_, 0L)}) {
    disk.FillUpTo(left);
    const long before = disk.Left();
    Page page;
    QVERIFY(page.BeginSession(case_, pictures));
    QTRY_VERIFY_WITH_TIMEOUT(page.Latest() && page.Latest()->frame.index >= 5, 30000);
    QVERIFY(page.Latest()->gate != GateState::Off);
    QTRY_VERIFY2(page.TextOf("recording").contains(kReason), qPrintable(page.TextOf("recording")));
    QVERIFY2(page.TextOf("recording").contains(case_ + "/sessions/"),
             qPrintable(page.TextOf("recording")));
    QTRY_VERIFY(page.TextOf("figures").contains("NOT RECORDED"));
    QTRY_VERIFY_WITH_TIMEOUT(page.widget->Shown() != nullptr, 30000);
    page.Click("snapshot");
    QTRY_VERIFY2(page.problems.contains("Snapshot not kept: the session is not recorded."),
                 qPrintable(page.problems.join("\n")));
    // Nothing half is left, neither of the video nor of a session, nor the room taken.
    QVERIFY(fs::is_empty((case_ + "/sessions").toStdString()));
    QCOMPARE(disk.Left(), before);
    page.Click("stop");
    QTRY_COMPARE_WITH_TIMEOUT(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Close, 30000);
    QVERIFY(page.TextOf("close_text").contains("was not recorded"));
    QVERIFY(page.widget->Desk().Unfinished().empty());
  }
}

int main(int argc, char** argv) {
  disk_folder = qEnvironmentVariable(kDiskAt);
  if (!disk_folder.isEmpty()) return RunGuiTest<FullDiskGuiTest>(argc, argv);
  QTemporaryDir folder;
  qputenv(kDiskAt, folder.path().toUtf8());
  return SmallDisk::RunAgainOn(folder.path().toStdString(), kDisk_MB, argv, kNoDisplay);
}

#include "FullDiskGuiTest.moc"
