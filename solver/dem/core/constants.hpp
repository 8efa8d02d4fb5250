#pragma once

namespace elutria
{

constexpr double pi = 3.14159265358979323846;

} // namespace elutria
