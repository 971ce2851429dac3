// SPDX-License-Identifier: Apache-2.0
// A value or the reason why there is none. Errors are values: dsp and the node's half of proto are built without exceptions.
#pragma once

#include <cassert>
#include <optional>
#include <utility>
#include <variant>

namespace srd {

// Why a computation gave no value. Text for people is made at the edge (drivers/support/problem.hpp).
enum class Errc : unsigned char {
  kInvalidArgument,  // the caller's numbers make no sense (NaN, negative size, empty list)
  kNotConverged,     // an iteration used up its steps
  kSingular,         // the geometry does not determine the answer
  kOutOfDomain,      // a ray misses the surface, a point lies behind the camera, total reflection
  kNotFound,         // nothing there: no corner, no pattern
  kAmbiguous,        // more than one answer fits equally well
  kTooSmall,         // a caller's buffer cannot hold the answer
};

[[nodiscard]] constexpr const char* to_string(Errc code) {
  switch (code) {
    case Errc::kInvalidArgument: return "invalid argument";
    case Errc::kNotConverged: return "not converged";
    case Errc::kSingular: return "singular";
    case Errc::kOutOfDomain: return "out of domain";
    case Errc::kNotFound: return "not found";
    case Errc::kAmbiguous: return "ambiguous";
    case Errc::kTooSmall: return "buffer too small";
  }
  return "unknown";
}

// Holds a T or an E. Asking for what is not there is a bug of the caller (assert).
template <class T, class E = Errc>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}  // NOLINT: meant to convert
  Result(E error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT: meant to convert

  [[nodiscard]] bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] T& value() & {
    assert(ok());
    return *std::get_if<0>(&state_);
  }
  [[nodiscard]] const T& value() const& {
    assert(ok());
    return *std::get_if<0>(&state_);
  }
  [[nodiscard]] T&& value() && {
    assert(ok());
    return std::move(*std::get_if<0>(&state_));
  }
  [[nodiscard]] const E& error() const {
    assert(!ok());
    return *std::get_if<1>(&state_);
  }
  [[nodiscard]] E& error() {
    assert(!ok());
    return *std::get_if<1>(&state_);
  }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

 private:
  std::variant<T, E> state_;
};

// Done, or the reason why not.
template <class E>
class [[nodiscard]] Result<void, E> {
 public:
  Result() = default;
  Result(E error) : error_(std::move(error)) {}  // NOLINT: meant to convert
  [[nodiscard]] bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] const E& error() const {
    assert(!ok());
    return *error_;
  }
  [[nodiscard]] E& error() {
    assert(!ok());
    return *error_;
  }

 private:
  std::optional<E> error_;
};

}  // namespace srd
