#include "reading/notes.h"

namespace planar_chain {

void Notes::add(const std::string& path, const std::string& text, int line) {
  const bool isFull = notes_.size() >= mostNotes && places_.count(text) == 0;
  const auto [place, isNew] = places_.emplace(isFull ? "other notes" : text, notes_.size());
  if (isNew) {
    notes_.push_back({path, place->first, line});
  } else {
    ++notes_[place->second].more;
  }
}

}  // namespace planar_chain
