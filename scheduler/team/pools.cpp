// See pools.hpp.
#include "scheduler/team/pools.hpp"

#include <utility>

namespace talus {

Scratch* ScratchPool::take(int slot) {
  if (slot >= 0 && static_cast<std::size_t>(slot) < home_.size())
    if (Scratch* s = std::exchange(home_[static_cast<std::size_t>(slot)].scratch, nullptr)) return s;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (free_.empty()) {
    all_.push_back(std::make_unique<Scratch>());
    return all_.back().get();
  }
  Scratch* s = free_.back();
  free_.pop_back();
  return s;
}

void ScratchPool::give(Scratch* s, int slot) {
  if (slot >= 0 && static_cast<std::size_t>(slot) < home_.size() &&
      home_[static_cast<std::size_t>(slot)].scratch == nullptr) {
    home_[static_cast<std::size_t>(slot)].scratch = s;
    return;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  free_.push_back(s);
}

std::size_t ScratchPool::bytes() const {
  std::size_t b = 0;
  for (const auto& s : all_) {
    b += (s->ci.capacity() + s->cj.capacity()) * 4 + (s->f.capacity() + s->m.capacity()) * 8 + s->before.capacity();
    for (const auto& h : s->h) b += h.capacity() * 8;
    b += s->late.size() * sizeof(LateContacts);
  }
  return b;
}

ListScratch* ListScratchPool::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (free_.empty()) {
    all_.push_back(std::make_unique<ListScratch>());
    return all_.back().get();
  }
  ListScratch* s = free_.back();
  free_.pop_back();
  return s;
}

void ListScratchPool::give(ListScratch* s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  free_.push_back(s);
}

std::size_t ListScratchPool::bytes() const {
  std::size_t b = 0;
  for (const auto& s : all_) {
    for (const auto* c : {&s->x, &s->y, &s->z, &s->r}) b += c->capacity() * sizeof(float);
    for (const auto& c : s->build) b += c.capacity() * sizeof(std::int32_t);
    b += (s->tag.capacity() + s->hits.capacity()) * sizeof(std::int32_t) + s->keys.capacity() * sizeof(std::uint64_t);
  }
  return b;
}

}  // namespace talus
