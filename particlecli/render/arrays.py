"""Types of the arrays that kernels take; NumPy arrays are passed as they are, without a copy."""

import taichi as ti

vec2 = ti.types.vector(2, ti.f32)
vec3 = ti.types.vector(3, ti.f32)
vec4 = ti.types.vector(4, ti.f32)

Row = ti.types.ndarray(dtype=ti.f32, ndim=1)
Rows = ti.types.ndarray(dtype=ti.f32, ndim=2)
Integers = ti.types.ndarray(dtype=ti.i32, ndim=1)
IntegerTable = ti.types.ndarray(dtype=ti.i32, ndim=2)
Ids = ti.types.ndarray(dtype=ti.i64, ndim=1)
Image = ti.types.ndarray(dtype=ti.f32, ndim=3)
Shorts = ti.types.ndarray(dtype=ti.u16, ndim=1)
