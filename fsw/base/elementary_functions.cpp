// Replacements of the C library's elementary functions for the whole program: ours, Ceres, OpenGV
// and OpenCV. Those of the C library are written for several kinds of processor and round
// differently with fused multiply-add; SLEEF's functions `cinz` give the same bits on all (decision
// 0105). A name that the program defines itself comes before the C library's, for shared libraries
// too.
#include <sleef.h>

namespace {

double wide(float x) { return static_cast<double>(x); }
float narrow(double x) { return static_cast<float>(x); }

}  // namespace

// Compiled with -fno-builtin: else the compiler may replace a function's body by a call of the same
// function.
extern "C" {

double sin(double x) noexcept { return Sleef_cinz_sind1_u10purec(x); }
double cos(double x) noexcept { return Sleef_cinz_cosd1_u10purec(x); }
double tan(double x) noexcept { return Sleef_cinz_tand1_u10purec(x); }
double asin(double x) noexcept { return Sleef_cinz_asind1_u10purec(x); }
double acos(double x) noexcept { return Sleef_cinz_acosd1_u10purec(x); }
double atan(double x) noexcept { return Sleef_cinz_atand1_u10purec(x); }
double atan2(double y, double x) noexcept { return Sleef_cinz_atan2d1_u10purec(y, x); }
double sinh(double x) noexcept { return Sleef_cinz_sinhd1_u10purec(x); }
double cosh(double x) noexcept { return Sleef_cinz_coshd1_u10purec(x); }
double exp(double x) noexcept { return Sleef_cinz_expd1_u10purec(x); }
// Each residual's loss takes a logarithm. This variant is off by at most 2.3 units in the last
// place; the more accurate one costs twice as much (decision 0105).
double log(double x) noexcept { return Sleef_cinz_logd1_u35purec(x); }
double exp2(double x) noexcept { return Sleef_cinz_exp2d1_u10purec(x); }
double log2(double x) noexcept { return Sleef_cinz_log2d1_u10purec(x); }
double log10(double x) noexcept { return Sleef_cinz_log10d1_u10purec(x); }
double log1p(double x) noexcept { return Sleef_cinz_log1pd1_u10purec(x); }
double pow(double x, double y) noexcept { return Sleef_cinz_powd1_u10purec(x, y); }
double cbrt(double x) noexcept { return Sleef_cinz_cbrtd1_u10purec(x); }
double hypot(double x, double y) noexcept { return Sleef_cinz_hypotd1_u05purec(x, y); }

void sincos(double x, double* sine, double* cosine) noexcept {
  const Sleef_double_2 both = Sleef_cinz_sincosd1_u10purec(x);
  *sine = both.x;
  *cosine = both.y;
}

// OpenGV takes the roots of its quartic by the complex logarithm.
__complex__ double clog(__complex__ double z) noexcept {
  __complex__ double result;
  __real__ result = log(hypot(__real__ z, __imag__ z));
  __imag__ result = atan2(__imag__ z, __real__ z);
  return result;
}

// In single precision: rounded once from the double, which is nearer than the C library's.
float sinf(float x) noexcept { return narrow(sin(wide(x))); }
float cosf(float x) noexcept { return narrow(cos(wide(x))); }
float asinf(float x) noexcept { return narrow(asin(wide(x))); }
float acosf(float x) noexcept { return narrow(acos(wide(x))); }
float atanf(float x) noexcept { return narrow(atan(wide(x))); }
float atan2f(float y, float x) noexcept { return narrow(atan2(wide(y), wide(x))); }
float expf(float x) noexcept { return narrow(exp(wide(x))); }
float exp2f(float x) noexcept { return narrow(exp2(wide(x))); }
float log2f(float x) noexcept { return narrow(log2(wide(x))); }
float logf(float x) noexcept { return narrow(log(wide(x))); }
float powf(float x, float y) noexcept { return narrow(pow(wide(x), wide(y))); }

void sincosf(float x, float* sine, float* cosine) noexcept {
  const Sleef_double_2 both = Sleef_cinz_sincosd1_u10purec(wide(x));
  *sine = narrow(both.x);
  *cosine = narrow(both.y);
}

}  // extern "C"
