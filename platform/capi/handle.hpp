// What the handles of the C interface are.
#pragma once

#include <array>

#include "capi/polhode.h"
#include "pipeline/component.hpp"

/// A job that is out.
struct polhode_job {
  polhode::Job* work = nullptr;  ///< null: the place is free
  bool done = false;
};

struct polhode_component {
  polhode::Component* component = nullptr;
  std::array<polhode_job, POLHODE_JOBS_MAX> jobs{};
  bool failed = false;  ///< a step was left by an exception: what the tables hold is unknown
};
