// Registration by a traced outline, with real mouse events: the model goes where the trace says.
#include <QImage>

#include "GuiScene.h"

using namespace kerf;
using namespace kerf::testing;

namespace {

/// The outline of a mask's first part from above, pixel by pixel in order; empty where the mask is.
std::vector<Vec2> OutlineOf(const QImage& mask) {
  const auto inside = [&](int x, int y) { return mask.valid(x, y) && qGray(mask.pixel(x, y)) > 0; };
  int x = 0, y = 0;
  while (y < mask.height() && !inside(x, y))
    if (++x == mask.width()) x = 0, ++y;
  if (y == mask.height()) return {};
  // Moore's walk around it, clockwise from the west of its first pixel.
  const int dx[] = {-1, -1, 0, 1, 1, 1, 0, -1}, dy[] = {0, -1, -1, -1, 0, 1, 1, 1};
  const int x0 = x, y0 = y;
  int from = 0;
  std::vector<Vec2> outline;
  do {
    outline.push_back({double(x), double(y)});
    for (int k = 1; k <= 8; ++k) {
      const int to = (from + k) % 8;
      if (!inside(x + dx[to], y + dy[to])) continue;
      x += dx[to];
      y += dy[to];
      from = (to + 4) % 8;
      break;
    }
  } while ((x != x0 || y != y0) && outline.size() < 20000);
  return outline;
}

}  // namespace

class TracedOutlineGuiTest : public QObject {
  Q_OBJECT

 private slots:
  void initTestCase();
  void cleanupTestCase() { page_.reset(); }
  void TheTrueOutlinePullsAWrongPoseIn();
  void AnOutlineTracedBesideItPullsItThere();

 private:
  /// With the mouse, moved by `by`.
  void Trace(const Vec2& by);
  /// Where the model lies off its true place in the picture, px: mean over its points.
  double Off_px(const Vec2& by = {0, 0});
  void Spoil();

  QTemporaryDir folder_;
  std::unique_ptr<Page> page_;
  CameraModel truth_;
  std::vector<Vec2> outline_;
};

void TracedOutlineGuiTest::initTestCase() {
  const std::string phantom = KERF_TEST_PHANTOM;
  const std::string planned = PlanStudyCase(phantom, folder_.path().toStdString() + "/case", 8000);
  truth_ = ReadCameraFile(phantom + "/truth/camera_true.yml");
  // The first second is at rest.
  const QImage mask(QString::fromStdString(phantom + "/truth/frame_00020_mask.png"));
  QVERIFY(!mask.isNull());
  outline_ = OutlineOf(mask);
  QVERIFY2(outline_.size() > 600 && outline_.size() < 5000,
           qPrintable(QString::number(outline_.size())));
  page_ = std::make_unique<Page>();
  page_->widget->OpenCase(QString::fromStdString(planned));
  page_->widget->OpenSource(QString::fromStdString(phantom + "/video.mp4"));
  QTRY_VERIFY_WITH_TIMEOUT(page_->widget->Desk().Newest().has_value(), 20000);
  page_->Type("confirmed", QString::fromStdString(page_->widget->Desk().Pseudonym()));
  QTRY_VERIFY_WITH_TIMEOUT(page_->Find<QPushButton>("register")->isEnabled(), 10000);
  page_->Click("register");
  QCOMPARE(page_->widget->CurrentStep(), qKerfIntraoperativeWidget::Exposure);
}

void TracedOutlineGuiTest::Trace(const Vec2& by) {
  page_->Click("trace_mode");
  auto* view = page_->widget->View();
  const auto at = [&](std::size_t i) { return page_->At(outline_[i] + by); };
  QTest::mousePress(view, Qt::LeftButton, {}, at(0));
  for (std::size_t i = 6; i < outline_.size(); i += 6) {
    QMouseEvent move(QEvent::MouseMove, at(i), Qt::NoButton, Qt::LeftButton, {});
    QApplication::sendEvent(view, &move);
  }
  QTest::mouseRelease(view, Qt::LeftButton, {}, at(outline_.size() - 1));
  QVERIFY(page_->widget->Desk().Exposure()->IsTraced());
}

double TracedOutlineGuiTest::Off_px(const Vec2& by) {
  const ExposureRegistration& exposure = *page_->widget->Desk().Exposure();
  const Points& points = exposure.Organ().points;
  double sum = 0;
  for (Index i = 0; i < points.rows(); ++i) {
    const Vec3 p = points.row(i).transpose();
    sum += (exposure.Camera().Project(p) - truth_.Project(p) - by).norm();
  }
  return sum / points.rows();
}

/// 4 mm aside and a little turned, by hand.
void TracedOutlineGuiTest::Spoil() {
  page_->Click("given");
  page_->Click("hand_mode");
  page_->Drag({480, 270}, {498, 262});
  page_->Drag({480, 270}, {488, 270}, Qt::RightButton);
}

void TracedOutlineGuiTest::TheTrueOutlinePullsAWrongPoseIn() {
  Spoil();
  const double wrong = Off_px();
  QVERIFY2(wrong > 15, qPrintable(QString::number(wrong)));
  Trace({0, 0});
  QTest::qWait(100);
  if (const QString pictures = qEnvironmentVariable("KERF_GUI_PICTURES"); !pictures.isEmpty())
    page_->widget->grab().save(pictures + "/intraoperative-traced.png");
  page_->Click("contour");
  QTRY_VERIFY2(Off_px() < 0.35 * wrong, qPrintable(QString::number(Off_px())));
  qInfo("model off its place: %.1f px, by the traced outline %.1f px", wrong, Off_px());
  QTRY_VERIFY(page_->Find<QPushButton>("undo_pose")->isEnabled());
  page_->Click("undo_pose");
  QCOMPARE(Off_px(), wrong);
}

/// It is the trace that counts, not the organ's colour.
void TracedOutlineGuiTest::AnOutlineTracedBesideItPullsItThere() {
  const Vec2 beside(25, 10);
  page_->Click("given");
  Trace(beside);
  page_->Click("contour");
  QTRY_VERIFY2(Off_px(beside) < 0.5 * beside.norm(), qPrintable(QString::number(Off_px(beside))));
  QVERIFY2(Off_px() > 0.6 * beside.norm(), qPrintable(QString::number(Off_px())));
  QVERIFY(page_->problems.isEmpty());
}

int main(int argc, char** argv) { return RunGuiTest<TracedOutlineGuiTest>(argc, argv); }

#include "TracedOutlineGuiTest.moc"
