#include "Pipelines/ReportPage.h"

#include <cstdint>

#include "Adapters/Rendering/ImageEncoding.h"
#include "CaseIO/AtomicFile.h"

namespace kerf {
namespace {

const char* const kStyle = R"(
:root{--ink:#1c2430;--soft:#5b6675;--line:#e3e7ec;--ground:#fff;--card:#f6f8fa;--accent:#2f6fde}
@media(prefers-color-scheme:dark){:root{--ink:#e6eaf0;--soft:#9aa6b5;--line:#2c343f;--ground:#12161c;--card:#1a2029;--accent:#78a7ff}}
*{box-sizing:border-box}body{margin:0;background:var(--ground);color:var(--ink);font:16px/1.55 system-ui,"Segoe UI",Roboto,"Helvetica Neue",Arial,sans-serif}
main{max-width:980px;margin:0 auto;padding:28px 20px 60px}h1{font-size:1.75rem;margin:0}h2{font-size:1.2rem;margin:2.2em 0 .6em}
.sub{color:var(--soft);margin:.2em 0 1.2em}.key{background:var(--card);border-left:4px solid var(--accent);border-radius:6px;padding:14px 20px;font-size:1.08rem;margin:16px 0}
.key p{margin:.35em 0}.warn{background:#fff3d6;color:#5c4300;border-left:4px solid #e0a100;border-radius:6px;padding:10px 16px;margin:12px 0}
figure{margin:14px 0}figure img{width:100%;border-radius:8px;display:block}figcaption{color:var(--soft);font-size:.9rem;margin-top:4px}
.row{display:grid;grid-template-columns:repeat(auto-fit,minmax(280px,1fr));gap:14px}.row figure{margin:0}
svg{width:100%;height:auto;display:block;background:var(--card);border-radius:8px;padding:6px}svg text{fill:var(--soft);font-size:12px}
svg .title{fill:var(--ink);font-weight:600;font-size:14px}svg .axis{font-size:12.5px}svg .note{fill:var(--ink);font-size:11.5px}
svg .grid{stroke:var(--line);fill:none}svg .curve{fill:none;stroke-width:1.8;stroke-linejoin:round}svg .mark{stroke:var(--ink);stroke-dasharray:3 3;fill:none}
svg .reference{stroke:var(--soft);stroke-dasharray:6 4;fill:none}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums;font-size:.95rem}th,td{padding:6px 10px;border-bottom:1px solid var(--line);text-align:right}
th{color:var(--soft);font-weight:600}th:first-child,td:first-child{text-align:left;white-space:nowrap}td{overflow-wrap:anywhere}
summary{cursor:pointer;font-size:1.2rem;font-weight:600;margin:2em 0 .6em}footer{margin-top:3em;color:var(--soft);font-size:.9rem;border-top:1px solid var(--line);padding-top:12px}
)";

std::string Base64(const std::vector<std::uint8_t>& bytes) {
  static const char* const kLetters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = std::uint32_t(bytes[i]) << 16;
    if (i + 1 < bytes.size()) three |= std::uint32_t(bytes[i + 1]) << 8;
    if (i + 2 < bytes.size()) three |= bytes[i + 2];
    out += kLetters[three >> 18];
    out += kLetters[three >> 12 & 63];
    out += i + 1 < bytes.size() ? kLetters[three >> 6 & 63] : '=';
    out += i + 2 < bytes.size() ? kLetters[three & 63] : '=';
  }
  return out;
}

std::string FigureOf(const Image& image, const std::string& caption) {
  return "<figure><img alt=\"" + EscapeHtml(caption) + "\" src=\"data:image/jpeg;base64," +
         Base64(EncodeJpeg(image, 88)) + "\"><figcaption>" + EscapeHtml(caption) +
         "</figcaption></figure>\n";
}

}  // namespace

ReportPage::ReportPage(const std::string& title, const std::string& subtitle) : title_(title) {
  body_ = "<h1>" + EscapeHtml(title) + "</h1>\n<p class=\"sub\">" + EscapeHtml(subtitle) + "</p>\n";
}

void ReportPage::CloseFold() {
  if (folded_) body_ += "</details>\n";
  folded_ = false;
}

void ReportPage::Heading(const std::string& text) {
  CloseFold();
  body_ += "<h2>" + EscapeHtml(text) + "</h2>\n";
}

void ReportPage::FoldedHeading(const std::string& text) {
  CloseFold();
  body_ += "<details><summary>" + EscapeHtml(text) + "</summary>\n";
  folded_ = true;
}

void ReportPage::Paragraph(const std::string& text) {
  body_ += "<p>" + EscapeHtml(text) + "</p>\n";
}

void ReportPage::KeySentences(const std::vector<std::string>& sentences) {
  body_ += "<div class=\"key\">";
  for (const std::string& s : sentences) body_ += "<p>" + EscapeHtml(s) + "</p>";
  body_ += "</div>\n";
}

void ReportPage::Warning(const std::string& text) {
  body_ += "<div class=\"warn\">" + EscapeHtml(text) + "</div>\n";
}

void ReportPage::Picture(const Image& image, const std::string& caption) {
  body_ += FigureOf(image, caption);
}

void ReportPage::Pictures(const std::vector<std::pair<Image, std::string>>& pictures) {
  body_ += "<div class=\"row\">";
  for (const auto& [image, caption] : pictures) body_ += FigureOf(image, caption);
  body_ += "</div>\n";
}

void ReportPage::Figure(const Plot& plot, const std::string& caption) {
  body_ += "<figure>" + ToSvg(plot);
  if (!caption.empty()) body_ += "<figcaption>" + EscapeHtml(caption) + "</figcaption>";
  body_ += "</figure>\n";
}

void ReportPage::Table(const std::vector<std::string>& header,
                       const std::vector<std::vector<std::string>>& rows) {
  body_ += "<table>";
  if (!header.empty()) {
    body_ += "<tr>";
    for (const std::string& cell : header) body_ += "<th>" + EscapeHtml(cell) + "</th>";
    body_ += "</tr>";
  }
  for (const auto& row : rows) {
    body_ += "<tr>";
    for (const std::string& cell : row) body_ += "<td>" + EscapeHtml(cell) + "</td>";
    body_ += "</tr>\n";
  }
  body_ += "</table>\n";
}

std::string ReportPage::Html() const {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
         "content=\"width=device-width,initial-scale=1\"><title>" +
         EscapeHtml(title_) + "</title><style>" + kStyle + "</style></head><body><main>\n" + body_ +
         (folded_ ? "</details>\n" : "") +
         "<footer>Research use, not a medical device. Positions in patient LPS, "
         "millimetres.</footer>\n"
         "</main></body></html>\n";
}

void ReportPage::Write(const std::string& path) const {
  AtomicFile file(path);
  file.Stream() << Html();
  file.Commit();
}

}  // namespace kerf
