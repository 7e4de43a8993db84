/*
 * What an exported model asks of <math.h>, where there is no C library: instructions of the machine, series and
 * polynomials without a branch, so that loops over lanes vectorise.
 */
#ifndef NARROWS_MATH_H
#define NARROWS_MATH_H

#define INFINITY __builtin_inff()
#define NAN __builtin_nanf("")
#define fabs __builtin_fabs
#define fabsf __builtin_fabsf
#define sqrt __builtin_sqrt
#define sqrtf __builtin_sqrtf
#define floor __builtin_floor
#define floorf __builtin_floorf
#define trunc __builtin_trunc
#define truncf __builtin_truncf

static inline double hypot(double a, double b) { return sqrt(a * a + b * b); }
static inline double fmod(double a, double b) { return a - b * trunc(a / b); }
static inline float hypotf(float a, float b) { return sqrtf(a * a + b * b); }
static inline float fmodf(float a, float b) { return a - b * truncf(a / b); }

/* e^x = 2^k e^r, k the nearest integer to x / ln 2: adding 1.5 2^52 rounds to it, in the low bits (Cody and Waite). */
static inline double exp(double x) {
    union { double number; unsigned long long bits; } shifted, power;
    x = x < -708.0 ? -708.0 : x > 709.0 ? 709.0 : x;
    shifted.number = x * 1.4426950408889634 + 0x1.8p52;
    const double whole = shifted.number - 0x1.8p52;
    const double r = x - whole * 6.93147180369123816490e-01 - whole * 1.90821492927058770002e-10;
    power.bits = (shifted.bits + 1023) << 52;
    double sum = 1.0 / 6227020800;
    sum = sum * r + 1.0 / 479001600, sum = sum * r + 1.0 / 39916800, sum = sum * r + 1.0 / 3628800;
    sum = sum * r + 1.0 / 362880, sum = sum * r + 1.0 / 40320, sum = sum * r + 1.0 / 5040;
    sum = sum * r + 1.0 / 720, sum = sum * r + 1.0 / 120, sum = sum * r + 1.0 / 24;
    sum = sum * r + 1.0 / 6, sum = sum * r + 0.5, sum = sum * r + 1, sum = sum * r + 1;
    return sum * power.number;
}
static inline float expf(float x) { return (float)exp(x); }

/* x = 2^k m, m about 1: ln m = 2 artanh((m - 1) / (m + 1)). */
static inline double log(double x) {
    union { double number; unsigned long long bits; } given = {x}, exponent;
    const unsigned long long shift = given.bits - 0x3fe6a09e667f3bcdULL;
    const long long power = (long long)shift >> 52;
    given.bits -= (unsigned long long)power << 52;
    exponent.bits = (unsigned long long)(power + 1024) | 0x4330000000000000ULL;
    const double s = (given.number - 1) / (given.number + 1), q = s * s;
    double sum = 1.0 / 19;
    sum = sum * q + 1.0 / 17, sum = sum * q + 1.0 / 15, sum = sum * q + 1.0 / 13, sum = sum * q + 1.0 / 11;
    sum = sum * q + 1.0 / 9, sum = sum * q + 1.0 / 7, sum = sum * q + 1.0 / 5, sum = sum * q + 1.0 / 3;
    return 2 * s * (1 + q * sum) + (exponent.number - 0x1p52 - 1024) * 0.6931471805599453;
}
static inline float logf(float x) { return (float)log(x); }
static inline double pow(double base, double power) {
    const double size = fabs(base), odd = trunc(power) != 2 * trunc(power * 0.5);
    const double value = size > 0 ? exp(power * log(size)) : power > 0 ? 0.0 : power < 0 ? INFINITY : 1.0;
    return base >= 0 ? value : trunc(power) != power ? NAN : odd ? -value : value;
}
static inline float powf(float base, float power) { return (float)pow(base, power); }

/* Series in Horner's form: to the last place up to a quarter turn, and no rudder turns further. */
#define SERIES(type, name, lead, a, b, c, d, e, f, g, h)                                                       \
    static inline type name(type x) {                                                                          \
        const type q = x * x;                                                                                  \
        return (lead) * ((type)1 + q * ((type)a + q * ((type)b + q * ((type)c + q * ((type)d + q * ((type)e +  \
            q * ((type)f + q * ((type)g + q * (type)h))))))));                                                 \
    }
#define SINE(type, name) SERIES(type, name, x, -1.0 / 6, 1.0 / 120, -1.0 / 5040, 1.0 / 362880, -1.0 / 39916800, \
    1.0 / 6227020800, -1.0 / 1307674368000, 1.0 / 355687428096000)
#define COSINE(type, name) SERIES(type, name, 1, -0.5, 1.0 / 24, -1.0 / 720, 1.0 / 40320, -1.0 / 3628800, \
    1.0 / 479001600, -1.0 / 87178291200, 1.0 / 20922789888000)
SINE(double, sin)
SINE(float, sinf)
COSINE(double, cos)
COSINE(float, cosf)

/* The angle halved twice, by tan(a/2) = t / (1 + sqrt(1 + t^2)), is within a short series' reach. */
static inline double atan2(double sine, double cosine) {
    const double size = sqrt(sine * sine + cosine * cosine), back = cosine < 0 ? -1 : 1;
    double t = (size > 0 ? sine : 0) / (size > 0 ? size + back * cosine : 1);
    t = t / (1 + sqrt(1 + t * t)), t = t / (1 + sqrt(1 + t * t));
    const double q = t * t;
    double sum = -1.0 / 23;
    sum = sum * q + 1.0 / 21, sum = sum * q - 1.0 / 19, sum = sum * q + 1.0 / 17, sum = sum * q - 1.0 / 15;
    sum = sum * q + 1.0 / 13, sum = sum * q - 1.0 / 11, sum = sum * q + 1.0 / 9, sum = sum * q - 1.0 / 7;
    sum = sum * q + 1.0 / 5, sum = sum * q - 1.0 / 3, sum = sum * q + 1;
    const double angle = 8 * t * sum;
    return cosine < 0 ? (sine < 0 ? -3.141592653589793 : 3.141592653589793) - angle : angle;
}
static inline float atan2f(float sine, float cosine) { return (float)atan2(sine, cosine); }
#endif
