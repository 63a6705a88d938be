#pragma once

#include <string>
#include <vector>

#include "Core/Frame.h"
#include "Pipelines/ReportPlot.h"

namespace kerf {

/// One self-contained HTML page: style, pictures and plots are inside the file. Every text is
/// escaped.
class ReportPage {
 public:
  explicit ReportPage(const std::string& title, const std::string& subtitle = "");
  void Heading(const std::string& text);
  void Paragraph(const std::string& text);
  /// The few sentences that a reader in a hurry takes away.
  void KeySentences(const std::vector<std::string>& sentences);
  void Warning(const std::string& text);
  void Picture(const Image& image, const std::string& caption);
  /// Pictures side by side.
  void Pictures(const std::vector<std::pair<Image, std::string>>& pictures);
  void Figure(const Plot& plot, const std::string& caption = "");
  /// First column left, numbers right. @param header may be empty
  void Table(const std::vector<std::string>& header,
             const std::vector<std::vector<std::string>>& rows);
  /// A section that is folded until it is clicked; everything up to the next heading of any kind
  /// belongs to it.
  void FoldedHeading(const std::string& text);
  /// The whole page with the research notice at its foot.
  std::string Html() const;
  /// Written in one step. @throws InputError naming the file
  void Write(const std::string& path) const;

 private:
  void CloseFold();
  std::string title_, body_;
  bool folded_ = false;
};

}  // namespace kerf
