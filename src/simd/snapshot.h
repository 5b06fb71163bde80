#pragma once

/// The values of objects as bytes. A class that has a state of its own lists its members once:
///
///     void saveOrRestore(Snapshot& snapshot) { snapshot(h_, count_, stepper_state_); }
///
/// It writes them, or reads them back into an object made with the same arguments. Members that follow from
/// others, and memory for results, are left out.

#include <cstddef>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

namespace planar_chain {

class Snapshot {
 public:
  /// Appends to `to`, which must outlive this object.
  static Snapshot writer(std::string& to) { return {&to, nullptr, nullptr}; }
  /// Reads `from`, which must outlive this object.
  static Snapshot reader(const std::string& from) {
    return {nullptr, from.data(), from.data() + from.size()};
  }

  bool isReading() const { return !to_; }
  /// @throws std::out_of_range if there are too few bytes to read
  template <class... Values>
  void operator()(Values&... values) {
    (take(values), ...);
  }
  /// `count` elements that are next to each other in memory.
  template <class Element>
  void block(Element* first, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<Element> && !std::is_pointer_v<Element>);
    const std::size_t size = count * sizeof(Element);
    if (to_) {
      if (size > 0) to_->append(reinterpret_cast<const char*>(first), size);
      return;
    }
    if (static_cast<std::size_t>(end_ - from_) < size) throw std::out_of_range("a state that ends too early");
    if (size > 0) std::memcpy(static_cast<void*>(first), from_, size);
    from_ += size;
  }

 private:
  Snapshot(std::string* to, const char* from, const char* end) : to_(to), from_(from), end_(end) {}

  template <class Value>
  using Own = decltype(std::declval<Value&>().saveOrRestore(std::declval<Snapshot&>()));
  template <class Value>
  using Sized = decltype(std::declval<Value&>().resize(std::declval<Value&>().size()));
  template <class Value>
  using Data = decltype(std::declval<Value&>().data());
  template <template <class> class Of, class Value, class = void>
  struct Has : std::false_type {};
  template <template <class> class Of, class Value>
  struct Has<Of, Value, std::void_t<Of<Value>>> : std::true_type {};

  template <class Value>
  void take(Value& value) {
    if constexpr (Has<Own, Value>::value) {
      value.saveOrRestore(*this);
    } else if constexpr (Has<Sized, Value>::value) {
      auto size = static_cast<std::size_t>(value.size());
      take(size);
      if (isReading()) value.resize(static_cast<decltype(value.size())>(size));
      takeElements(value, size);
    } else {
      block(&value, 1);
    }
  }
  template <class Values>
  static constexpr bool isBlock() {
    if constexpr (Has<Data, Values>::value) {
      return std::is_trivially_copyable_v<std::remove_pointer_t<Data<Values>>>;
    } else {
      return false;
    }
  }
  template <class Values>
  void takeElements(Values& values, std::size_t size) {
    if constexpr (isBlock<Values>()) {
      block(values.data(), size);
    } else {
      for (auto& value : values) take(value);
    }
  }
  template <class First, class Second>
  void take(std::pair<First, Second>& value) {
    (*this)(value.first, value.second);
  }
  template <class Value>
  void take(std::optional<Value>& value) {
    bool has = value.has_value();
    take(has);
    if (isReading() && has != value.has_value()) has ? void(value.emplace()) : value.reset();
    if (has) take(*value);
  }

  std::string* to_;
  const char *from_, *end_;
};

}  // namespace planar_chain
