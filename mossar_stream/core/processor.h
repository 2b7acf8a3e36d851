/* Whether the processor runs x86-64-v3. */
#ifndef MOSSAR_PROCESSOR_H
#define MOSSAR_PROCESSOR_H

#if (defined(__GNUC__) || defined(__clang__)) && defined(__x86_64__)

static int mossar_has_x86_64_v3(void) {
    /* Processors with these have the rest of the level: LZCNT, MOVBE, F16C. Old compilers do not know the level's name. */
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi")
        && __builtin_cpu_supports("bmi2");
}

#elif defined(_MSC_VER) && defined(_M_X64)

#include <immintrin.h>
#include <intrin.h>

static int mossar_has_x86_64_v3(void) {
    const int FMA = 1 << 12, OSXSAVE = 1 << 27, BMI = 1 << 3, AVX2 = 1 << 5, BMI2 = 1 << 8;
    int basic[4], extended[4]; /* EAX, EBX, ECX, EDX */
    __cpuid(basic, 0);
    if (basic[0] < 7) return 0;
    __cpuid(basic, 1);
    __cpuidex(extended, 7, 0);
    if (!(basic[2] & FMA) || !(basic[2] & OSXSAVE) || !(extended[1] & BMI) || !(extended[1] & AVX2) || !(extended[1] & BMI2))
        return 0;
    return (_xgetbv(0) & 6) == 6; /* the system saves the wide registers */
}

#else

static int mossar_has_x86_64_v3(void) {
    return 0;
}

#endif
#endif
