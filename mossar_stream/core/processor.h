/* Whether the processor runs x86-64-v3. */
#ifndef MOSSAR_PROCESSOR_H
#define MOSSAR_PROCESSOR_H

#if defined(__x86_64__) || defined(_M_X64)

#ifdef _MSC_VER
#include <intrin.h>
#else
#include <cpuid.h>
#endif

/* Asked of the processor itself: with zig, __builtin_cpu_supports knows no processor and answers no. */
static void mossar_cpuid(unsigned leaf, unsigned answer[4]) { /* EAX, EBX, ECX, EDX */
#ifdef _MSC_VER
    __cpuidex((int *)answer, (int)leaf, 0);
#else
    __cpuid_count(leaf, 0, answer[0], answer[1], answer[2], answer[3]);
#endif
}

static unsigned mossar_saved_registers(void) {
#ifdef _MSC_VER
    return (unsigned)_xgetbv(0);
#else
    unsigned low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
#endif
}

static int mossar_has_x86_64_v3(void) {
    const unsigned fma = 1u << 12, movbe = 1u << 22, osxsave = 1u << 27, f16c = 1u << 29; /* of leaf 1, ECX */
    const unsigned bmi1 = 1u << 3, avx2 = 1u << 5, bmi2 = 1u << 8;                        /* of leaf 7, EBX */
    const unsigned lzcnt = 1u << 5;                                                       /* of leaf 0x80000001, ECX */
    const unsigned first = fma | movbe | osxsave | f16c, second = bmi1 | avx2 | bmi2;
    unsigned answer[4];
    mossar_cpuid(0, answer);
    if (answer[0] < 7) return 0;
    mossar_cpuid(1, answer);
    if ((answer[2] & first) != first) return 0;
    mossar_cpuid(7, answer);
    if ((answer[1] & second) != second) return 0;
    mossar_cpuid(0x80000000u, answer);
    if (answer[0] < 0x80000001u) return 0;
    mossar_cpuid(0x80000001u, answer);
    return (answer[2] & lzcnt) && (mossar_saved_registers() & 6) == 6; /* the system saves the wide registers */
}

#else

static int mossar_has_x86_64_v3(void) {
    return 0;
}

#endif
#endif
