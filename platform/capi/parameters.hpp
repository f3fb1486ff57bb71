// Implementation of the C interface's parameters.
#pragma once

#include "capi/polhode.h"
#include "pipeline/parameters.hpp"

struct polhode_parameters {
  polhode::Parameters values;
};
