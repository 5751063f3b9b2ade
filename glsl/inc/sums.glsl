// What the threads of a group gather for four rows, and its sum over all of them. Includers say how many threads there are: LANES.

// A number each: an array that is indexed by what a driver on the CPU does not know beforehand it keeps in memory, and stores to a lane at a time.
struct Sums {
    vec3 first;
    vec3 second;
    vec3 third;
    vec3 fourth;
};

// What four columns send.
struct Light {
    vec3 first;
    vec3 second;
    vec3 third;
    vec3 fourth;
};

shared vec3 halves[4][LANES];

// The row's sum over all threads, added halves onto halves, for threads 0 to 3. All of a group call it.
vec3 over_threads(Sums sums, uint lane) {
    halves[0][lane] = sums.first;
    halves[1][lane] = sums.second;
    halves[2][lane] = sums.third;
    halves[3][lane] = sums.fourth;
    for (uint width = LANES >> 1u; width > 0u; width /= 2u) {
        barrier();
        if (lane < width) {
            for (uint down = 0u; down < 4u; ++down) {
                precise vec3 sum = halves[down][lane] + halves[down][lane + width];
                halves[down][lane] = sum;
            }
        }
    }
    barrier();
    return halves[lane & 3u][0];
}
