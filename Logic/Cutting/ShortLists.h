#pragma once

#include <algorithm>
#include <vector>

namespace kerf {

/// Lists of numbers in one block of memory, so that all of them are copied at once. A list that
/// outgrows its room moves to the end of the block.
class ShortLists {
 public:
  /// Valid until the next change.
  class List {
   public:
    List(const int* first, int size) : first_(first), size_(size) {}
    const int* begin() const { return first_; }
    const int* end() const { return first_ + size_; }
    int size() const { return size_; }
    int operator[](int i) const { return first_[i]; }

   private:
    const int* first_;
    int size_;
  };

  std::size_t Count() const { return places_.size(); }
  List operator[](std::size_t list) const {
    return {numbers_.data() + places_[list].first, places_[list].size};
  }
  void Reserve(std::size_t lists, std::size_t numbers) {
    places_.reserve(lists);
    numbers_.reserve(numbers);
  }
  /// One more list, empty.
  void Add(int room) {
    places_.push_back({static_cast<int>(numbers_.size()), 0, room});
    numbers_.resize(numbers_.size() + room);
  }
  void Push(std::size_t list, int number) {
    Place& place = places_[list];
    if (place.size == place.room) {
      const int first = static_cast<int>(numbers_.size());
      place.room = 2 * place.room + 8;
      numbers_.resize(first + place.room);
      std::copy_n(numbers_.begin() + place.first, place.size, numbers_.begin() + first);
      place.first = first;
    }
    numbers_[place.first + place.size++] = number;
  }
  /// Removes the numbers for which `drop` holds, keeps the order of the others.
  template <class Drop>
  void RemoveIf(std::size_t list, Drop drop) {
    int* const first = numbers_.data() + places_[list].first;
    places_[list].size =
        static_cast<int>(std::remove_if(first, first + places_[list].size, drop) - first);
  }

 private:
  struct Place {
    int first, size, room;
  };
  std::vector<Place> places_;
  std::vector<int> numbers_;
};

}  // namespace kerf
