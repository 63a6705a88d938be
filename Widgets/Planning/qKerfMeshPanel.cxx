#include "Planning/qKerfMeshPanel.h"

#include <QCheckBox>
#include <QLabel>
#include <QPushButton>
#include <QSlider>
#include <QVBoxLayout>
#include <cmath>

#include "Planning/PanelParts.h"

using namespace kerf_panel;

qKerfMeshPanel::qKerfMeshPanel(QWidget* parent)
    : QWidget(parent), slider_(new QSlider(Qt::Horizontal)) {
  slider_->setObjectName("tetrahedraSlider");
  // Logarithmic: 2,000 to 50,000.
  slider_->setRange(0, 100);
  slider_->setValue(63);
  expected_ = Value("expectedTetrahedra");
  make_ = Primary(tr("Make the mesh"), "meshButton");
  report_ = Value("meshReport");
  embedding_ = Value("embeddingReport");
  quality_ = new QCheckBox(tr("Show quality (smallest angle) on the mesh"));
  quality_->setObjectName("qualityCheck");
  auto* column = Column(this);
  column->addWidget(Heading(tr("Resolution")));
  column->addWidget(slider_);
  column->addWidget(expected_);
  column->addWidget(
      Hint(tr("15,000 keeps up with video on two cores; finer follows the organ "
              "more closely.")));
  column->addWidget(make_);
  column->addWidget(report_);
  column->addWidget(embedding_);
  column->addWidget(quality_);
  column->addStretch(1);
  connect(slider_, &QSlider::valueChanged, this, [this] { ShowExpected(organ_ml_); });
  connect(make_, &QPushButton::clicked, this, &qKerfMeshPanel::MeshWanted);
  connect(quality_, &QCheckBox::toggled, this, &qKerfMeshPanel::QualityToggled);
}

int qKerfMeshPanel::Tetrahedra() const {
  const double n = 2000.0 * std::pow(25.0, slider_->value() / 100.0);
  return static_cast<int>(std::lround(n / 500.0)) * 500;
}

bool qKerfMeshPanel::QualityShown() const { return quality_->isChecked(); }

void qKerfMeshPanel::ShowExpected(double organ_ml) {
  organ_ml_ = organ_ml;
  QString text = tr("About <b>%L1</b> tetrahedra").arg(Tetrahedra());
  // A regular tetrahedron of edge a has a³ / 8.49; cells of the mesher are a little fuller.
  if (organ_ml > 0)
    text += tr(", edges about %1 mm")
                .arg(std::cbrt(8.49 * organ_ml * 1000.0 / Tetrahedra()), 0, 'f', 1);
  expected_->setText(text);
}

void qKerfMeshPanel::Show(const kerf::PlanningSession& session) {
  double ml = 0;
  for (const int label : {1, 2, 3}) ml += session.Labels().Volume_ml(label);
  ShowExpected(ml);
  make_->setEnabled(!session.Labels().Empty());
  const auto& model = session.Model();
  quality_->setEnabled(model != nullptr);
  if (!model) {
    report_->setText({});
    embedding_->setText({});
    return;
  }
  const kerf::MeshQuality& q = model->quality;
  const double error =
      model->input_volume_mm3 > 0 ? 100.0 * (q.volume_mm3 / model->input_volume_mm3 - 1.0) : 0.0;
  report_->setText(tr("<table cellspacing=2><tr><td>Tetrahedra&nbsp;</td><td><b>%L1</b></td></tr>"
                      "<tr><td>Vertices</td><td>%L2</td></tr>"
                      "<tr><td>Smallest angle&nbsp;</td><td>%3°</td></tr>"
                      "<tr><td>Volume</td><td>%4 ml (%5 %)</td></tr>"
                      "<tr><td>Boundary</td><td>%6</td></tr></table>")
                       .arg(q.tets)
                       .arg(q.vertices)
                       .arg(q.smallest_dihedral_deg, 0, 'f', 1)
                       .arg(q.volume_mm3 / 1000.0, 0, 'f', 1)
                       .arg((error < 0 ? QStringLiteral("−") : QStringLiteral("+")) +
                            QString::number(std::abs(error), 'f', 2))
                       .arg(q.manifold_boundary ? tr("closed") : tr("not closed")));
  QString text = tr("<b>Embedded</b>");
  for (const kerf::Structure& s : model->structures)
    text += tr("<br>%1: %L2 points, %3 ml")
                .arg(s.name == "internal" ? tr("vessels, calyces") : tr("tumour"))
                .arg(s.rest.points.rows())
                .arg(s.rest.SignedVolume() / 1000.0, 0, 'f', 1);
  if (model->structures.empty()) text += tr("<br>no inner structures");
  text += model->points_outside == 0 ? tr("<br>all points inside the mesh")
                                     : tr("<br>%L1 points outside, at most %2 mm")
                                           .arg(model->points_outside)
                                           .arg(model->farthest_outside_mm, 0, 'f', 2);
  embedding_->setText(text);
}
