// The statistics of a parametrization as JSON.
#pragma once

#include "core/json.hpp"
#include "cubecover/parametrize.hpp"

namespace neurframe {

void describe(const Parametrization& result, Json& statistics);

}  // namespace neurframe
