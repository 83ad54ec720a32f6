// 1/x for x > 0 to about an ulp, from correctly rounded operations alone: the same bits everywhere.
float reciprocal(float x) {
    precise float r = uintBitsToFloat(0x7ef311c7u - floatBitsToUint(x));
    for (int i = 0; i < 4; ++i) {
        precise float error = 1.0 - x * r;
        r = r + r * error;
    }
    return r;
}
