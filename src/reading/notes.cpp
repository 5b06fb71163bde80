#include "reading/notes.h"

namespace planar_chain {

void Notes::add(const std::string& path, const std::string& text, int line) {
  const bool isFull = notes_.size() >= mostNotes && indices_.count(text) == 0;
  const auto [entry, isNew] = indices_.emplace(isFull ? "other notes" : text, notes_.size());
  if (isNew) {
    notes_.push_back({path, entry->first, line});
  } else {
    ++notes_[entry->second].more;
  }
}

}  // namespace planar_chain
