// The registry of row columns: what each holds, why, and what happens to it when rows are added, sorted, saved and
// loaded. Who uses it: the owners of columns (scheduler/state, lists, parts) register theirs; capacity, sort epochs,
// checkpoints, hashes and `explain` loop over it. Invariant: whoever adds a column says here all that others need to
// know of it, so that none of them has to name it.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "core/base/types.hpp"

namespace talus {

/// What is known of a column beside its values.
struct ColumnInfo {
  std::string name;  ///< section of the checkpoint
  std::string unit;
  std::string label;            ///< in `explain`; empty: the name
  std::string why;              ///< what needs it, or why it is left out
  bool in = true;               ///< false: it has no bytes; only `explain` knows it
  int width = 1;                ///< values per row
  std::vector<double> dead{0};  ///< of rows that nobody lives in: one value for all, or one for each of `width`
  bool moves = true;            ///< goes with its row at a sort epoch; false: made anew after it
  bool saved = false;           ///< in the checkpoint
  bool output = false;          ///< in particle files, under its name; one double per row
  bool optional = false;        ///< a checkpoint may lack it: rows then hold the dead value
  std::uint64_t hash_seed = 0;  ///< of its own term in the state hash; 0: it has none
};

class Columns {
 public:
  /// A registered column. Pointers are to its owner's, which must not move.
  struct Entry {
    ColumnInfo info;
    std::size_t bytes = 0;  ///< per row
    void* column = nullptr;
    void* spare = nullptr;  ///< its second buffer, or null
    void (*resize)(void*, std::size_t values) = nullptr;
    void (*fill)(const ColumnInfo&, void*, Row from, Row to) = nullptr;
    void (*swap)(void*, void*) = nullptr;
    unsigned char* (*data_of)(void*) = nullptr;
    std::size_t (*bytes_of)(const void*) = nullptr;
    unsigned char* data() const { return data_of(column); }
  };

  Columns() = default;
  Columns(const Columns&) = delete;
  Columns& operator=(const Columns&) = delete;

  /// `spare`: a second buffer of the same shape that changes places with the column.
  template <class T>
  void add(ColumnInfo info, Column<T>& column, Column<T>* spare = nullptr) {
    static_assert(std::is_trivially_copyable_v<T>);
    Entry e;
    e.bytes = sizeof(T) * static_cast<std::size_t>(info.width);
    e.info = std::move(info);
    if (e.info.label.empty()) e.info.label = e.info.name;
    e.column = &column;
    e.spare = spare;
    e.resize = [](void* c, std::size_t values) { static_cast<Column<T>*>(c)->resize(values); };
    e.fill = [](const ColumnInfo& i, void* c, Row from, Row to) {
      T* at = static_cast<Column<T>*>(c)->data() + static_cast<std::ptrdiff_t>(i.width) * from;
      for (Row row = from; row < to; ++row)
        for (int k = 0; k < i.width; ++k)
          *at++ = static_cast<T>(i.dead[i.dead.size() == 1 ? 0 : static_cast<std::size_t>(k)]);
    };
    e.swap = [](void* a, void* b) { std::swap(*static_cast<Column<T>*>(a), *static_cast<Column<T>*>(b)); };
    e.data_of = [](void* c) { return reinterpret_cast<unsigned char*>(static_cast<Column<T>*>(c)->data()); };
    e.bytes_of = [](const void* c) { return static_cast<const Column<T>*>(c)->capacity() * sizeof(T); };
    all_.push_back(std::move(e));
  }

  const std::vector<Entry>& all() const noexcept { return all_; }

  /// Room for `rows` rows in every column; those from `first` on are dead.
  void resize(std::size_t rows, Row first) const {
    for (const Entry& e : all_) {
      if (!e.info.in) continue;
      for (void* c : {e.column, e.spare}) {
        if (c == nullptr) continue;
        e.resize(c, rows * static_cast<std::size_t>(e.info.width));
        e.fill(e.info, c, first, static_cast<Row>(rows));
      }
    }
  }

  /// The first n rows of every saved column that both have.
  void copy_saved(const Columns& from, std::size_t n) const {
    for (const Entry& e : all_)
      for (const Entry& o : from.all_)
        if (e.info.in && o.info.in && e.info.saved && e.info.name == o.info.name)
          std::memcpy(e.data(), o.data(), e.bytes * n);
  }

  /// Memory of all columns [B].
  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const Entry& e : all_)
      for (const void* c : {e.column, e.spare})
        if (c != nullptr) sum += e.bytes_of(c);
    return sum;
  }

 private:
  std::vector<Entry> all_;
};

}  // namespace talus
