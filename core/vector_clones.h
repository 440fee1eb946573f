#pragma once

/// SACCADE_VECTOR_CLONES before a function: it is compiled for AVX2 as well, and the better one is chosen at run time.
/// AVX2 alone has no fused multiply-add, so both give the same bits. Empty where compiler or sanitizers cannot do it, and with
/// SACCADE_WITHOUT_VECTOR_CLONES, for a test of these bits.
#if !defined(SACCADE_WITHOUT_VECTOR_CLONES) && defined(__x86_64__) && defined(__GNUC__) && \
    !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SACCADE_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define SACCADE_VECTOR_CLONES
#endif
