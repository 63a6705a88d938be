#include "Planning/qKerfStepList.h"

#include <QButtonGroup>
#include <QLabel>
#include <QPainter>
#include <QToolButton>
#include <QVBoxLayout>
#include <QVariant>

#include "Common/qKerfTheme.h"

namespace {

/// A disc with the step's number, a tick or an exclamation mark.
QIcon MarkOf(int step, kerf::StepState state) {
  const qKerfTheme& t = qKerfTheme::Current();
  QPixmap pixmap(44, 44);
  pixmap.fill(Qt::transparent);
  QPainter painter(&pixmap);
  painter.setRenderHint(QPainter::Antialiasing);
  const QColor color = state == kerf::StepState::Done      ? t.good
                       : state == kerf::StepState::Problem ? t.warning
                                                           : t.faint;
  painter.setPen(QPen(color, 3));
  if (state != kerf::StepState::ToDo) painter.setBrush(color);
  painter.drawEllipse(QRectF(3, 3, 38, 38));
  painter.setPen(QPen(state == kerf::StepState::ToDo ? t.text : t.window, 4, Qt::SolidLine,
                      Qt::RoundCap, Qt::RoundJoin));
  if (state == kerf::StepState::Done) {
    painter.drawPolyline(QPolygonF({{13, 23}, {20, 30}, {32, 15}}));
  } else {
    QFont font = painter.font();
    font.setPixelSize(24);
    font.setBold(true);
    painter.setFont(font);
    painter.drawText(
        QRect(0, 0, 44, 44), Qt::AlignCenter,
        state == kerf::StepState::Problem ? QStringLiteral("!") : QString::number(step + 1));
  }
  return QIcon(pixmap);
}

}  // namespace

qKerfStepList::qKerfStepList(QWidget* parent)
    : QWidget(parent), group_(new QButtonGroup(this)), sentence_(new QLabel) {
  setObjectName("stepList");
  const QStringList titles{tr("Import"), tr("Segment"),           tr("Mesh and embed"),
                           tr("Plan"),   tr("Camera, landmarks"), tr("Check and save")};
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(0, 0, 0, 0);
  column->setSpacing(1);
  for (int s = 0; s < titles.size(); ++s) {
    auto* button = new QToolButton;
    button->setObjectName(QStringLiteral("step%1").arg(s));
    button->setText("  " + titles[s]);
    button->setToolTip(tr("Step %1 (Alt+%1)").arg(s + 1));
    button->setToolButtonStyle(Qt::ToolButtonTextBesideIcon);
    button->setIconSize(QSize(18, 18));
    button->setCheckable(true);
    button->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
    group_->addButton(button, s);
    buttons_.push_back(button);
    sentences_ << QString();
    column->addWidget(button);
    connect(button, &QToolButton::clicked, this, [this, s] { SetCurrent(s); });
  }
  sentence_->setObjectName("stepSentence");
  sentence_->setWordWrap(true);
  sentence_->setMinimumHeight(52);  // three lines: the steps below it never move
  sentence_->setAlignment(Qt::AlignTop | Qt::AlignLeft);
  sentence_->setContentsMargins(4, 4, 4, 0);
  column->addWidget(sentence_);
  buttons_[0]->setChecked(true);
}

void qKerfStepList::SetCurrent(int step) {
  current_ = step;
  buttons_[step]->setChecked(true);
  sentence_->setText(sentences_[step]);
  emit StepChosen(step);
}

void qKerfStepList::Show(const kerf::PlanningSession& session) {
  for (int s = 0; s < kerf::kPlanningSteps; ++s) {
    const kerf::StepStatus status = session.Status(static_cast<kerf::PlanningStep>(s));
    buttons_[s]->setIcon(MarkOf(s, status.state));
    buttons_[s]->setProperty("state", static_cast<int>(status.state));
    sentences_[s] = QString::fromStdString(status.sentence);
    if (status.state == kerf::StepState::Done && s + 1 < kerf::kPlanningSteps)
      sentences_[s] += tr("\nNext: %1.").arg(buttons_[s + 1]->text().trimmed());
  }
  sentence_->setText(sentences_[current_]);
}
