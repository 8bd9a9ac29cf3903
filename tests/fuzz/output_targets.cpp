// What a run has written and other commands read: series.csv and summary.json.
#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>

#include "core/base/error.hpp"
#include "core/io/series.hpp"
#include "core/io/summary.hpp"
#include "tests/fuzz/memory_file.hpp"

namespace talus::fuzz {

namespace {

SeriesLayout layout() {
  SeriesLayout l;
  l.walls = {"floor"};
  l.planes = {"gate"};
  l.energies = true;
  return l;
}

bool reads_whole(const std::string& path) {
  try {
    check_series(path);
    return true;
  } catch (const Error& e) {
    check_message(e);
    return false;
  }
}

}  // namespace

void series(Bytes input) {
  if (input.empty()) return;
  const MemoryFile file(input.subspan(1));
  const bool whole = reads_whole(file.path());
  try {
    SeriesWriter w = SeriesWriter::resume(file.path(), layout(), input[0]);
    claim(w.last_step() <= input[0], "rows later than the checkpoint were kept");
    SeriesRow row;
    row.step = std::max<std::int64_t>(w.last_step() + 1, 0);
    row.walls.resize(1);
    row.planes.resize(1);
    w.append(row);
    claim(reads_whole(file.path()) || !whole, "a whole series is damaged by a resume");
    std::ifstream in(file.path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    claim(!text.empty() && text.back() == '\n', "rows do not appear whole");
  } catch (const Error& e) {
    check_message(e);
  }
}

void summary(Bytes input) {
  const MemoryFile file(input);
  try {
    claim(read_summary_text(file.path()).size() == input.size(), "a summary is not read as it stands");
  } catch (const Error& e) {
    check_message(e);
  }
}

}  // namespace talus::fuzz
