// What a session leaves: complete, exported, replayed bit by bit, played again in the window.
#include <filesystem>
#include <fstream>

#include "CaseIO/JournalRead.h"
#include "IntraoperativeGuiTest.h"
#include "Pipelines/ReplayPipeline.h"
#include "Pipelines/SessionPlayback.h"
#include "Pipelines/SessionSource.h"

using namespace kerf;
using namespace kerf::testing;
namespace fs = std::filesystem;

namespace {

std::string Content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

void IntraoperativeGuiTest::TheSessionIsCompleteExportedAndReplayedBitByBit() {
  page_->Key(Qt::Key_S);
  page_->Key(Qt::Key_M);
  auto* clamp = page_->Find<QPushButton>("clamp");
  page_->Key(Qt::Key_K);
  QTRY_VERIFY_WITH_TIMEOUT(clamp->text().contains("Ischaemia 0:01"), 5000);
  page_->Click("clamp");
  QVERIFY(!clamp->isChecked());
  QVERIFY2(clamp->text().contains("was closed 0:0"), qPrintable(clamp->text()));
  QTest::qWait(300);
  page_->Click("stop");
  QTRY_COMPARE_WITH_TIMEOUT(page_->widget->CurrentStep(), qKerfIntraoperativeWidget::Close, 20000);
  const fs::path session = page_->widget->Desk().SessionPath();
  QVERIFY(session.parent_path().filename() == "sessions");
  for (const char* name :
       {"session.json", "journal.jsonl", "frames.csv", "states.csv", "camera.yml", "video.mp4",
        "organ_final.vtu", "tumour_final.vtp", "cuts.json", "report.html", "snapshots"})
    QVERIFY2(fs::exists(session / name), name);
  QVERIFY(ReadSession(session.string()).finished);
  std::set<std::string> events;
  for (const JournalEntry& entry : ReadJournal((session / "journal.jsonl").string()))
    events.insert(entry.event);
  for (const char* event :
       {"registration accepted", "cut proposed", "cut accepted", "cut applied", "cut rejected",
        "undone", "cut drawn", "mark", "snapshot", "clamp closed", "clamp opened", "end"})
    QVERIFY2(events.count(event), event);

  QVERIFY(page_->Exports());
  ReplayRequest request;
  request.study = session.string();
  request.results = folder_.path().toStdString() + "/replayed";
  const std::string pictures = qEnvironmentVariable("KERF_GUI_PICTURES").toStdString();
  if (pictures.empty()) request.drawing = kerf::ReplayRequest::Drawing::None;
  Progress silent;
  const ReplayResult result = Replay(request, silent);  // throws where a checksum differs
  QCOMPARE(result.cuts, 1);
  for (const char* name : {"organ_final.vtu", "tumour_final.vtp", "cuts.json"})
    QVERIFY2(Content(session / name) == Content(fs::path(request.results) / name), name);
  // As after kill -9: unfinished, the last lines cut off. It is offered, and what is whole is
  // read.
  const fs::path broken = session.parent_path() / "29991231-235959";
  fs::copy(session, broken, fs::copy_options::recursive);
  SessionFolder unfinished = ReadSession(broken.string());
  unfinished.finished = false;
  WriteSession(unfinished);
  for (const char* name : {"frames.csv", "states.csv"})
    fs::resize_file(broken / name, fs::file_size(broken / name) - 5);
  const auto offered = page_->widget->Desk().Unfinished();
  QVERIFY(offered.size() == 1 && fs::path(offered[0]) == broken);
  QCOMPARE(SessionSource(unfinished).FrameCount(), result.frames - 1);

  fs::remove_all(broken);
  QVERIFY(page_->problems.isEmpty());
  if (!pictures.empty())
    fs::copy_file(folder_.path().toStdString() + "/replayed/overlay.mp4",
                  pictures + "/intraoperative-overlay.mp4", fs::copy_options::overwrite_existing);
}

void IntraoperativeGuiTest::TheSessionIsPlayedAgainInTheWindow() {
  page_->Click("play_session");
  QCOMPARE(page_->widget->CurrentStep(), qKerfIntraoperativeWidget::Review);
  SessionPlayback* playback = page_->widget->Playback();
  const int last = playback->FrameCount() - 1;
  // Every frame is done again and its checksum held against the recorded one.
  QTRY_VERIFY2_WITH_TIMEOUT(playback->Ready() == last + 1 || !playback->Problem().empty(),
                            playback->Problem().c_str(), 120000);
  QCOMPARE(playback->Problem(), std::string());
  QTRY_VERIFY(page_->widget->Shown() && page_->widget->Shown()->frame.index == 0);
  auto* timeline = page_->Find<QSlider>("timeline");
  const auto click_at = [&](int frame) {
    const int x = 8 + int(double(frame) * (timeline->width() - 16) / last + 0.5);
    QTest::mouseClick(timeline, Qt::LeftButton, {}, QPoint(x, timeline->height() / 2));
  };
  const auto shows = [&](int frame) {
    return page_->widget->Shown() && page_->widget->Shown()->frame.index == frame;
  };
  // Anywhere and back: the same model and the same picture.
  click_at(last);
  QTRY_VERIFY(shows(last));
  const auto end = page_->widget->Shown();
  // What was decided after the last picture is shown over it: the cuts that were drawn and undone.
  auto* events = page_->Find<QListWidget>("review_events");
  QCOMPARE(end->cuts.size(), std::size_t(3));
  QVERIFY(end->cuts[0].state == CutItem::State::Applied && end->cuts[0].before);
  for (const int undone : {1, 2}) QVERIFY(end->cuts[undone].state == CutItem::State::Rejected);
  const auto drawn = events->findItems("cut drawn", Qt::MatchEndsWith);
  QCOMPARE(drawn.size(), 2);
  const int drawn_frame = drawn[0]->data(Qt::UserRole).toInt();
  click_at(drawn_frame);
  QTRY_VERIFY(shows(drawn_frame));
  QVERIFY(page_->widget->Shown()->cuts.size() == 2 &&
          page_->widget->Shown()->cuts[1].state == CutItem::State::Applied);
  QVERIFY(page_->widget->Shown()->frame.image->data == end->frame.image->data);
  click_at(last);
  QTRY_VERIFY(shows(last));
  const QImage picture = page_->widget->View()->Picture().copy();
  click_at(10);
  QTRY_VERIFY(shows(10));
  QVERIFY(page_->widget->Shown()->cuts.empty());
  QVERIFY(Difference(page_->widget->View()->Picture(), picture) > 0.05);
  click_at(last);
  QTRY_VERIFY(shows(last));
  QVERIFY(page_->widget->Shown()->organ.points == end->organ.points);
  QCOMPARE(Difference(page_->widget->View()->Picture(), picture), 0.0);
  // What happened: one click goes there.
  int proposed = -1;
  for (int i = 0; i < events->count(); ++i)
    if (events->item(i)->text().contains("cut proposed")) proposed = i;
  QVERIFY(proposed >= 0);
  events->scrollToItem(events->item(proposed));
  QTest::mouseClick(events->viewport(), Qt::LeftButton, {},
                    events->visualItemRect(events->item(proposed)).center());
  const int cut_frame = events->item(proposed)->data(Qt::UserRole).toInt();
  QTRY_VERIFY(shows(cut_frame));
  QVERIFY(!page_->widget->Shown()->cuts.empty());
  QTest::qWait(100);
  Keep("review");
  // At its own speed: after some pictures, those of then.
  page_->Key(Qt::Key_Right);
  QTRY_VERIFY(shows(cut_frame + 1));
  page_->Key(Qt::Key_Left);
  QTRY_VERIFY(shows(cut_frame));
  click_at(10);
  QTRY_VERIFY(shows(10));
  page_->Key(Qt::Key_Space);
  QTRY_VERIFY_WITH_TIMEOUT(page_->widget->Shown()->frame.index > 15, 10000);
  page_->Key(Qt::Key_Space);
  QTest::qWait(100);
  const int stood = page_->widget->Shown()->frame.index;
  QTest::qWait(200);
  QVERIFY(shows(stood));
  QCOMPARE(playback->FrameAt(playback->TimeOf_s(stood) + 1e-6), stood);
  page_->Click("step1");
  QCOMPARE(page_->widget->CurrentStep(), qKerfIntraoperativeWidget::CheckIn);
  QVERIFY(!page_->widget->Playback());
  QVERIFY(page_->Find<QPushButton>("play_recorded")->isVisible());
  QVERIFY(page_->problems.isEmpty());
}

void IntraoperativeGuiTest::ASessionThatDoesNotFitSaysWhere() {
  const fs::path session = page_->widget->Desk().SessionPath();
  const fs::path other = session.parent_path() / "29991231-235958";
  fs::copy(session, other, fs::copy_options::recursive);
  std::string states = Content(other / "states.csv");
  const std::size_t line = states.find("\n30,");
  states[states.find('\n', line + 1) - 1] ^= 1;  // one bit of a checksum
  std::ofstream(other / "states.csv", std::ios::binary) << states;
  page_->widget->OpenRecorded(QString::fromStdString(other.string()));
  SessionPlayback* playback = page_->widget->Playback();
  QVERIFY(playback);
  QTRY_VERIFY_WITH_TIMEOUT(!playback->Problem().empty(), 60000);
  QVERIFY(playback->Problem().find("frame 30") != std::string::npos);
  QCOMPARE(playback->Ready(), 30);
  QTRY_VERIFY(page_->Find<QLabel>("review_state")->text().contains("Only the first 30 frames"));
  page_->Click("step1");
  fs::remove_all(other);
  page_->widget->OpenRecorded(QString::fromStdString(other.string()));
  QCOMPARE(page_->problems.size(), 1);  // a folder that is not there is a sentence
  page_->problems.clear();
}
