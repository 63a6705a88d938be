// report.html: self-contained, safe against odd names, true to its data.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "Pipelines/Report.h"
#include "Pipelines/ReportPage.h"
#include "Pipelines/ReportPlot.h"
#include "SceneFixtures.h"

namespace kerf {
namespace {

int Count(const std::string& text, const std::string& what) {
  int n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

// Every opened tag is closed in order: what a browser would have to repair is an error of ours.
::testing::AssertionResult WellFormed(const std::string& html) {
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) return ::testing::AssertionFailure() << "unclosed tag at " << at;
    const std::string tag = html.substr(at + 1, end - at - 1);
    const std::string name = tag.substr(0, tag.find_first_of(" /"));
    if (tag[0] == '!' || tag.back() == '/' || name == "meta" || name == "img") continue;
    if (tag[0] != '/') {
      open.push_back(name);
    } else if (open.empty() || open.back() != tag.substr(1)) {
      return ::testing::AssertionFailure()
             << tag << " closes " << (open.empty() ? "nothing" : open.back());
    } else {
      open.pop_back();
    }
  }
  if (!open.empty()) return ::testing::AssertionFailure() << open.back() << " is never closed";
  return ::testing::AssertionSuccess();
}

ReportData Example() {
  ReportData data;
  data.study = "phantom <one> & \"two\"";
  data.method = "kerf";
  data.warnings = {"The video broke in frame 119: everything before it is kept."};
  for (int f = 0; f < 120; ++f) {
    const double score = f < 60 ? 0.95 - 0.05 * std::sin(f / 7.0) : f < 75 ? 0.55 : 0.9;
    data.reliability.push_back({f, f / 25.0, f >= 60 && f < 75 ? "amber" : "green", score,
                                f >= 60 && f < 75 ? "few features left" : "ok", 2.0 + f / 100.0});
    data.fit.push_back({f / 25.0, 0.2, 1.0 + f / 100.0});
    TimingRow t;
    t.frame = f;
    t.tracking_ms = 4 + std::sin(f / 5.0);
    t.targets_ms = 0.5;
    t.detection_ms = 0.1;
    t.cutting_ms = f == 62 ? 6 : 0;
    t.solve_ms = f == 0 ? 80 : 3;
    t.structures_ms = 0.2;
    t.render_ms = 30;
    t.total_ms = 45;
    data.timing.push_back(t);
  }
  Points line(3, 3);
  line << 0, 0, 0, 10, 0, 0, 10, 14, 0;
  data.cuts = {{62, line, 21, 0.9}};
  for (int f : {0, 62, 90})
    data.snapshots.push_back({f, f / 25.0, *testing::TissuePicture(320, 180)});
  data.planned_mesh = data.final_mesh = MeshQuality{};
  data.parameters = {{"young_kPa", "15"}, {"study", "a<b"}};
  data.versions = {{"Kerf", "0.1.0"}};
  Scores scores;
  scores.frames = {{20, {{"organ_mean", 0.4}}, 0}, {60, {{"organ_mean", 0.9}}, 0}};
  scores.final_values = {{"dice", 0.961}, {"organ_mean", 0.9}};
  data.scores = scores;
  return data;
}

std::string Written(const ReportData& data, const std::string& name) {
  const char* preview = std::getenv("KERF_OVERLAY_PREVIEW");
  const auto file =
      (preview ? std::filesystem::path(preview) : std::filesystem::path(::testing::TempDir())) /
      name;
  WriteReport(file.string(), data);
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST(Report, IsOneWellFormedFileThatAsksForNothingElse) {
  const std::string html = Written(Example(), "report.html");
  EXPECT_TRUE(WellFormed(html));
  for (const char* outside : {"http://", "https://", "<script", "<link", "src=\"/", "url("})
    EXPECT_EQ(Count(html, outside), 0) << outside;
  EXPECT_EQ(Count(html, "data:image/jpeg;base64,"), 3);
  EXPECT_EQ(Count(html, "<svg"), 5);
  EXPECT_GE(Count(html, "Research use, not a medical device"), 1);
}

TEST(Report, NamesCannotBecomeMarkup) {
  ReportData data = Example();
  data.study = "<script>alert(1)</script>";
  data.warnings = {"a < b & 'c'"};
  const std::string html = Written(data, "report-escape.html");
  EXPECT_EQ(Count(html, "<script"), 0);
  EXPECT_GE(Count(html, "&lt;script&gt;"), 1);
  EXPECT_EQ(Count(html, "a &lt; b &amp; &#39;c&#39;"), 1);
}

TEST(Report, KeySentencesSayTrustCutAndAccuracy) {
  const auto s = KeySentences(Example());
  ASSERT_EQ(s.size(), 3u);
  EXPECT_EQ(s[0],
            "The overlay was trusted (green) in 88 % of 120 frames, amber in 12 % and off in 0 %; "
            "most often "
            "because: few features left. At the end it was green.");
  EXPECT_NE(s[1].find("at 2.48 s (frame 62), 24 mm long"), std::string::npos) << s[1];
  EXPECT_NE(s[2].find("(Dice) 0.961"), std::string::npos) << s[2];
}

TEST(Report, NoCutAndNoCuttingAreToldApart) {
  ReportData data = Example();
  data.cuts.clear();
  EXPECT_EQ(KeySentences(data)[1], "No cut was found.");
  data.cutting = false;
  EXPECT_EQ(KeySentences(data)[1], "Cutting was switched off for this run.");
}

TEST(Report, NearlyEmptyDataStillGivesAReport) {
  ReportData data;
  data.study = "empty";
  EXPECT_TRUE(WellFormed(Written(data, "report-empty.html")));
  data.reliability.push_back({0, 0.0, "off", std::nan(""), "no features", std::nan("")});
  data.timing.push_back({});
  const std::string html = Written(data, "report-one.html");
  EXPECT_TRUE(WellFormed(html));
  EXPECT_EQ(Count(html, "nan"), 0);
  EXPECT_EQ(Count(html, "inf"), 0);
}

TEST(Plot, GapsInterruptTheCurve) {
  Plot plot;
  plot.series = {{"a", {0, 1, 2, 3, 4}, {1, 2, std::nan(""), 2, 1}, ""}};
  const std::string svg = ToSvg(plot);
  const std::size_t curve = svg.find("class=\"curve\" d=\"");
  ASSERT_NE(curve, std::string::npos);
  const std::string path = svg.substr(curve, svg.find("\" stroke", curve) - curve);
  EXPECT_EQ(Count(path, "M"), 2);
  EXPECT_EQ(Count(path, "L"), 2);
}

TEST(Plot, StackedAreasEndAtTheSum) {
  Plot plot;
  plot.stacked = true;
  plot.series = {{"a", {0, 1}, {1, 2}, ""}, {"b", {0, 1}, {3, 8}, ""}};
  // The axis ends at 10, so the top of b (10 at x = 1) is at the plot's upper edge.
  EXPECT_NE(ToSvg(plot).find("L840.0 30.0"), std::string::npos) << ToSvg(plot);
}

TEST(Plot, TicksAreRoundNumbers) {
  EXPECT_EQ(NiceTicks(0, 10, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(NiceTicks(0, 0.7, 5).size(), 5u);
  EXPECT_EQ(NiceTicks(3, 3, 5), std::vector<double>{3});
  EXPECT_EQ(NiceTicks(0, std::numeric_limits<double>::infinity(), 5).size(), 1u);
}

}  // namespace
}  // namespace kerf
