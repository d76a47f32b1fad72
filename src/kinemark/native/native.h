/* What all sources of the library share.

   Plain C99 that knows nothing of Python: compiled_library.py loads it with ctypes. What is computed, and why, is written in the
   Python modules that each file names, where NumPy does the same; the tests compare the two, and the numbers of
   equations are theirs.

   The caller allocates all memory and passes its size; the Python modules check dtypes, shapes and indices before a
   call. Whatever the numbers in the arrays are, nothing outside of them is read or written. Indices have 64 bits. */

#ifndef KINEMARK_NATIVE_H
#define KINEMARK_NATIVE_H

#include <stdint.h>

#ifdef _WIN32
#define API __declspec(dllexport)
#else
#define API __attribute__((visibility("default")))
#endif

/* Before a function that goes over many numbers: compiled for several processors, and that is taken which the one at hand
   can run. All give the same to the last bit, as setup.py asks for no fused products. -DCLONES= makes one. */
#ifdef CLONES
#elif defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#if __GNUC__ >= 12
#define CLONES __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define CLONES __attribute__((target_clones("avx2", "default")))
#endif
#else
#define CLONES
#endif

#endif
