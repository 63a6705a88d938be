#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace kerf::testing {

/// Writes small DICOM files byte by byte (explicit VR, little endian), so that a test can break
/// what a library would repair.
struct DicomFile {
  std::map<std::uint32_t, std::pair<std::string, std::string>> elements;  ///< tag → VR, bytes

  DicomFile(int columns, int rows, double z_mm, int instance) {
    Text(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.2");
    Text(0x00080018, "UI", "1.2.3.4." + std::to_string(instance));
    Text(0x00080060, "CS", "CT");
    Text(0x0008103e, "LO", "abdomen");
    Text(0x00100010, "PN", "Doe^Jane");
    Text(0x00100020, "LO", "P1");
    Text(0x00180050, "DS", "2");
    Text(0x0020000d, "UI", "1.2.3");
    Text(0x0020000e, "UI", "1.2.3.4");
    Text(0x00200011, "IS", "1");
    Position(10, -20, z_mm);
    Text(0x00200037, "DS", "1\\0\\0\\0\\1\\0");
    Text(0x00280030, "DS", "0.5\\0.75");
    Text(0x00281052, "DS", "-1024");
    Text(0x00281053, "DS", "1");
    Text(0x00280004, "CS", "MONOCHROME2");
    Number(0x00280002, 1);
    Number(0x00280010, rows);
    Number(0x00280011, columns);
    Number(0x00280100, 16);
    Number(0x00280101, 12);
    Number(0x00280102, 11);
    Number(0x00280103, 0);
    SetPixels(columns, rows, [&](int i, int j) { return 524 + 10 * i + 100 * j + instance; });
  }

  void Text(std::uint32_t tag, const std::string& vr, std::string text) {
    if (text.size() % 2) text += vr == "UI" ? '\0' : ' ';
    elements[tag] = {vr, text};
  }
  void Number(std::uint32_t tag, int value) {
    elements[tag] = {"US", {static_cast<char>(value & 0xff), static_cast<char>(value >> 8)}};
  }
  void Position(double x, double y, double z) {
    Text(0x00200032, "DS", std::to_string(x) + "\\" + std::to_string(y) + "\\" + std::to_string(z));
  }

  /// 16 bits each. @param at stored value of column i, row j
  template <class At>
  void SetPixels(int columns, int rows, At at) {
    std::string pixels;
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) {
        const int value = at(i, j);
        pixels += static_cast<char>(value & 0xff);
        pixels += static_cast<char>(value >> 8);
      }
    elements[0x7fe00010] = {"OW", pixels};
  }

  std::string Bytes() const {
    std::string out(128, '\0');
    out += "DICM";
    DicomFile meta(*this, 0);
    meta.Text(0x00020002, "UI", "1.2.840.10008.5.1.4.1.1.2");
    meta.Text(0x00020003, "UI", "1.2.3.4.9");
    meta.Text(0x00020010, "UI", "1.2.840.10008.1.2.1");
    const std::string group2 = meta.Elements();
    std::string length;
    for (int b = 0; b < 4; ++b) length += static_cast<char>((group2.size() >> (8 * b)) & 0xff);
    DicomFile head(*this, 0);
    head.elements[0x00020000] = {"UL", length};
    return out + head.Elements() + group2 + Elements();
  }
  void Write(const std::filesystem::path& path) const {
    std::ofstream(path, std::ios::binary) << Bytes();
  }

 private:
  DicomFile(const DicomFile&, int) {}

  std::string Elements() const {
    std::string out;
    const auto put = [&](std::uint64_t value, int bytes) {
      for (int b = 0; b < bytes; ++b) out += static_cast<char>((value >> (8 * b)) & 0xff);
    };
    for (const auto& [tag, element] : elements) {
      put(tag >> 16, 2);
      put(tag & 0xffff, 2);
      out += element.first;
      if (element.first == "OW") {
        put(0, 2);
        put(element.second.size(), 4);
      } else {
        put(element.second.size(), 2);
      }
      out += element.second;
    }
    return out;
  }
};

}  // namespace kerf::testing
