#include "Common/qKerfMessageBar.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QStyle>
#include <QToolButton>
#include <QVariant>

qKerfMessageBar::qKerfMessageBar(QWidget* parent)
    : QFrame(parent), mark_(new QLabel), text_(new QLabel) {
  setObjectName("messageBar");
  setProperty("role", "panel");
  text_->setObjectName("messageText");
  text_->setWordWrap(true);
  text_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  auto* close = new QToolButton;
  close->setText(QStringLiteral("✕"));
  close->setToolTip(tr("Close this message"));
  connect(close, &QToolButton::clicked, this, &qKerfMessageBar::Close);
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(10, 4, 4, 4);
  row->addWidget(mark_);
  row->addWidget(text_, 1);
  row->addWidget(close);
  hide();
}

void qKerfMessageBar::Show(Level level, const QString& text) {
  text_->setText(text);
  mark_->setText(level == Info      ? tr("Note")
                 : level == Warning ? tr("Please check")
                                    : tr("Problem"));
  mark_->setProperty("role", level == Info ? "good" : level == Warning ? "warning" : "problem");
  mark_->style()->unpolish(mark_);
  mark_->style()->polish(mark_);
  setVisible(!text.isEmpty());
}

QString qKerfMessageBar::Text() const { return isHidden() ? QString() : text_->text(); }

void qKerfMessageBar::Close() { hide(); }
