// Outcome of a call that may fail for reasons that lie outside our own code.
#pragma once

#include <string>
#include <utility>
#include <variant>

#include "base/assert.hpp"

namespace polhode {

enum class ErrorCode {
  kBadParameter,  ///< a parameter is out of its range; the message names field, value and range
  kTooFewObservations,  ///< fewer data than unknowns
  kNoConsensus,         ///< no hypothesis gathered enough inliers
  kDegenerate,          ///< the geometry does not determine the answer
  kNotConverged,        ///< an iteration ended without a usable solution
  kMemoryTooSmall,      ///< the memory handed over is smaller than memory_needed()
};

struct Error {
  ErrorCode code = ErrorCode::kDegenerate;
  std::string message;  ///< for people: what, where, allowed range (empty on the frame path)
};

/// A value or the reason why there is none.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::move(value)) {}        // NOLINT(google-explicit-constructor)
  Result(Error error) : content_(std::move(error)) {}    // NOLINT(google-explicit-constructor)
  Result(ErrorCode code) : content_(Error{code, {}}) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return std::holds_alternative<T>(content_); }
  explicit operator bool() const { return ok(); }

  [[nodiscard]] T& value() {
    POLHODE_ASSERT(ok(), 0.0);
    return std::get<T>(content_);
  }
  [[nodiscard]] const T& value() const {
    POLHODE_ASSERT(ok(), 0.0);
    return std::get<T>(content_);
  }
  [[nodiscard]] const Error& error() const {
    POLHODE_ASSERT(!ok(), 0.0);
    return std::get<Error>(content_);
  }

 private:
  std::variant<T, Error> content_;
};

}  // namespace polhode
