#include "Adapters/Itk/DicomStructure.h"

#include <fmt/format.h>

#include <cstdint>
#include <fstream>
#include <set>

#include "Core/Errors.h"

namespace kerf {
namespace {

constexpr std::uint32_t kUndefined = 0xffffffff, kItem = 0xfffee000, kItemEnd = 0xfffee00d,
                        kSequenceEnd = 0xfffee0dd, kPixelData = 0x7fe00010,
                        kTransferSyntax = 0x00020010;
constexpr int kDeepest = 32;

class Walker {
 public:
  explicit Walker(const std::string& path) : path_(path), in_(path, std::ios::binary) {
    in_.seekg(0, std::ios::end);
    size_ = in_ ? std::uint64_t(in_.tellg()) : 0;
    in_.seekg(0);
  }

  bool Check() {
    char head[132] = {};
    in_.read(head, sizeof head);
    const bool preamble = in_.gcount() == 132 && std::string(head + 128, 4) == "DICM";
    in_.clear();
    in_.seekg(0);
    if (!preamble) {
      // Files of old archives start with the first elements themselves.
      const bool begins =
          size_ > 8 && (head[0] == 8 || head[0] == 2) && head[1] == 0 && head[3] == 0;
      if (!begins) return false;
      at_ = 0;
    } else {
      at_ = 132;
    }
    Meta();
    // Big endian and deflated data sets are left to the library: nobody writes CT that way.
    if (syntax_ == "1.2.840.10008.1.2.2" || syntax_ == "1.2.840.10008.1.2.1.99") return true;
    explicit_ = syntax_.empty() ? LooksExplicit() : syntax_ != "1.2.840.10008.1.2";
    DataSet(size_, false, 0);
    return true;
  }

 private:
  struct Element {
    std::uint32_t tag = 0, length = 0;
    std::string vr;
  };

  std::uint64_t Read(int bytes) {
    unsigned char raw[4] = {};
    in_.seekg(std::streamoff(at_));
    in_.read(reinterpret_cast<char*>(raw), bytes);
    if (in_.gcount() != bytes) Broken(last_);
    at_ += std::uint64_t(bytes);
    std::uint64_t value = 0;
    for (int b = bytes - 1; b >= 0; --b) value = value << 8 | raw[b];
    return value;
  }

  [[noreturn]] void Broken(std::uint32_t tag) const {
    throw InputError(path_, fmt::format("element ({:04X},{:04X})", tag >> 16, tag & 0xffff),
                     tag == kPixelData ? "the slice is truncated: the file ends in its pixel data"
                                       : "the file is truncated or damaged here");
  }

  bool LooksExplicit() {
    const std::uint64_t here = at_;
    at_ += 4;
    const std::uint64_t vr = Read(2);
    at_ = here;
    const auto letter = [](std::uint64_t c) { return c >= 'A' && c <= 'Z'; };
    return letter(vr & 0xff) && letter(vr >> 8);
  }

  Element Next(bool explicit_vr) {
    Element e;
    const std::uint64_t group = Read(2);
    e.tag = std::uint32_t(group << 16 | Read(2));
    if (e.tag != kItem && e.tag != kItemEnd && e.tag != kSequenceEnd) last_ = e.tag;
    if (e.tag >> 16 == 0xfffe || !explicit_vr) {
      e.length = std::uint32_t(Read(4));
      return e;
    }
    const std::uint64_t vr = Read(2);
    e.vr = {char(vr & 0xff), char(vr >> 8)};
    static const std::set<std::string> kLong = {"OB", "OW", "OF", "OD", "OL", "OV", "SQ",
                                                "SV", "UV", "UC", "UR", "UT", "UN"};
    if (kLong.count(e.vr)) {
      Read(2);
      e.length = std::uint32_t(Read(4));
    } else {
      e.length = std::uint32_t(Read(2));
    }
    return e;
  }

  void Skip(const Element& e) {
    if (at_ + e.length > size_) Broken(last_);
    at_ += e.length;
  }

  void Meta() {
    while (at_ + 8 <= size_) {
      const std::uint64_t here = at_;
      if (Read(2) != 2) {
        at_ = here;
        return;
      }
      at_ = here;
      const Element e = Next(true);
      if (at_ + e.length > size_) Broken(e.tag);
      if (e.tag == kTransferSyntax) {
        syntax_.resize(e.length);
        in_.seekg(std::streamoff(at_));
        in_.read(syntax_.data(), std::streamsize(e.length));
        while (!syntax_.empty() && (syntax_.back() == '\0' || syntax_.back() == ' '))
          syntax_.pop_back();
      }
      at_ += e.length;
    }
  }

  /// Elements up to `end`, or up to the item's delimiter.
  void DataSet(std::uint64_t end, bool delimited, int depth) {
    const bool explicit_vr = explicit_;
    while (at_ < end) {
      const Element e = Next(explicit_vr);
      if (delimited && e.tag == kItemEnd) return;
      if (e.length != kUndefined) {
        Skip(e);
        continue;
      }
      if (e.tag == kPixelData) {
        Items(true, depth);
        return;
      }
      const bool was = explicit_;
      if (e.vr == "UN") explicit_ = false;
      Items(false, depth);
      explicit_ = was;
    }
    if (delimited) Broken(last_);
  }

  /// Items of a sequence of undefined length, or fragments of compressed pixel data.
  void Items(bool fragments, int depth) {
    if (depth > kDeepest) Broken(last_);
    for (;;) {
      const Element item = Next(explicit_);
      if (item.tag == kSequenceEnd) return;
      if (item.tag != kItem) Broken(last_);
      if (item.length != kUndefined)
        Skip(item);
      else if (!fragments)
        DataSet(size_, true, depth + 1);
      else
        Broken(last_);
    }
  }

  std::string path_;
  std::ifstream in_;
  std::uint64_t size_ = 0, at_ = 0;
  std::uint32_t last_ = 0;
  std::string syntax_;
  bool explicit_ = true;
};

}  // namespace

bool CheckDicomStructure(const std::string& path) { return Walker(path).Check(); }

}  // namespace kerf
