#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "Core/Types.h"

namespace kerf {

/// What hangs together, of things numbered from 0. A set goes by its smallest member.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : root_(count) {
    std::iota(root_.begin(), root_.end(), Index(0));
  }
  Index Find(Index i) {
    while (root_[i] != i) i = root_[i] = root_[root_[i]];
    return i;
  }
  void Join(Index a, Index b) {
    a = Find(a);
    b = Find(b);
    root_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<Index> root_;
};

}  // namespace kerf
