// Lobes. exp and log are our own: drivers differ by up to 5 % in pow (PEERS.md). CPU twin: reference/shade.rs.
// One model, or that of each material.
layout(constant_id = 6) const uint SHADING = SHADING_GLTF;

// log(1 - x) for x in [0, 1): atanh series after a split of the mantissa; a few ulp for small x, where lobes are high.
float log_one_minus(float x) {
    precise float y = 1.0 - x;
    if (y <= 0.0) {
        return -1e30;
    }
    int e = 0;
    precise float z;
    if (x < 0.29289322) {
        z = -x / (2.0 - x);
    } else {
        uint bits = floatBitsToUint(y);
        e = int(bits >> 23) - 127;
        float m = uintBitsToFloat((bits & 0x7fffffu) | 0x3f800000u);
        if (m > 1.41421356) {
            m *= 0.5;
            e += 1;
        }
        z = (m - 1.0) / (m + 1.0);
    }
    precise float z2 = z * z;
    precise float series = 2.0 * z * (1.0 + z2 * (0.33333333333 + z2 * (0.2 + z2 * (0.14285714286 + z2 * (0.11111111111 + z2 * 0.09090909091)))));
    precise float result = float(e) * 0.69314718056 + series;
    return result;
}

// exp(x) for x <= 0: Cody-Waite reduction and a Taylor polynomial of degree 7 on [-ln2/2, ln2/2] (error under 2^-26).
float exp_negative(float x) {
    if (x < -87.0) {
        return 0.0;
    }
    precise float k = floor(x * 1.44269504089 + 0.5);
    precise float r = (x - k * 0.693145751953125) - k * 1.42860682030941723e-6;
    precise float p = 1.0 + r * (1.0 + r * (0.5 + r * (0.16666666667 + r * (0.04166666667 + r * (0.00833333333 + r * (0.00138888889 + r * 0.0001984127))))));
    return p * uintBitsToFloat(uint(int(k) + 127) << 23);
}

struct Lobes {
    vec3 diffuse;
    vec3 specular;
    float alpha2;
    float shininess;
    float view_term;
    // Towards the silhouette.
    vec3 rim;
    uint model;
};

// x^power for x in [0, 1] and a positive power.
float power_of(float x, float power) {
    precise float y = power * log_one_minus(1.0 - x);
    return x > 0.0 ? exp_negative(y) : 0.0;
}

uint model_of(Lobes lobes) {
    if (SHADING != SHADING_MIXED) {
        return SHADING;
    }
    return lobes.model;
}

// What a surface sends out without any light of the table.
vec3 unlit_radiance(Surface s) {
    precise vec3 sum = frame.data.ambient * s.occlusion * s.base_color + s.emissive;
    return sum;
}

// Reflectance at normal incidence.
vec3 specular_color(Surface s) {
    precise vec3 f0 = mix(vec3(0.04), s.base_color, s.metallic);
    return f0;
}

// What does not depend on the light.
Lobes make_lobes(Surface s, vec3 v) {
    Lobes lobes;
    lobes.model = s.model;
    lobes.rim = vec3(0.0);
    uint model = model_of(lobes);
    precise float nv = abs(dot(s.normal, v));
    if (model == SHADING_CAR_PAINT) {
        precise float share = power_of(min(nv, 1.0), s.model_exponent);
        precise vec3 paint = mix(s.model_color, s.base_color, share);
        s.base_color = paint;
    }
    if (model == SHADING_RIM) {
        precise vec3 rim = s.model_color * power_of(1.0 - min(nv, 1.0), s.model_exponent);
        lobes.rim = rim;
    }
    lobes.specular = specular_color(s);
    precise float alpha = s.roughness * s.roughness;
    lobes.alpha2 = alpha * alpha;
    if (model == SHADING_LAMBERT || model == SHADING_PHONG) {
        lobes.diffuse = model == SHADING_LAMBERT ? s.base_color * (1.0 / PI) : s.base_color;
        lobes.shininess = clamp(2.0 / lobes.alpha2 - 2.0, 1.0, 1024.0);
        lobes.view_term = 0.0;
    } else {
        lobes.diffuse = s.base_color * ((1.0 - s.metallic) * (1.0 / PI));
        lobes.view_term = nv + sqrt(lobes.alpha2 + (1.0 - lobes.alpha2) * nv * nv);
        lobes.shininess = 0.0;
    }
    return lobes;
}

// Reflected radiance for unit irradiance: diffuse, plus Blinn's lobe (phong) or GGX with Smith and Schlick (gltf).
// H = l + v stays unnormalised: |H| cancels from the lobes, and v.h is |H| / 2 because l and v are unit vectors.
vec3 reflect_light(Lobes lobes, Surface s, vec3 v, vec3 l, float nl) {
    uint model = model_of(lobes);
    if (model == SHADING_LAMBERT) {
        return lobes.diffuse;
    }
    precise vec3 h = l + v;
    precise float h2 = dot(h, h);
    precise vec3 across = cross(s.normal, h);
    // |n x H|^2 = H^2 (1 - (n.h)^2): no cancellation at the peak of the lobe.
    precise float sin2 = min(dot(across, across), h2);
    bool front = dot(s.normal, h) > 0.0;
    if (model == SHADING_PHONG) {
        float lobe = front ? exp_negative(0.5 * lobes.shininess * log_one_minus(sin2 / h2)) : 0.0;
        return lobes.diffuse + lobes.specular * lobe;
    }
    precise float w = 1.0 - min(0.5 * sqrt(h2), 1.0);
    precise float w2 = w * w;
    precise vec3 fresnel = lobes.specular + (1.0 - lobes.specular) * (w2 * w2 * w);
    precise float d = sin2 + lobes.alpha2 * (h2 - sin2);
    precise float light_term = nl + sqrt(lobes.alpha2 + (1.0 - lobes.alpha2) * nl * nl);
    precise float lobe = (lobes.alpha2 * h2) * h2 / ((PI * d) * d * (light_term * lobes.view_term));
    precise vec3 result = (1.0 - fresnel) * lobes.diffuse + fresnel * (front ? lobe : 0.0);
    if (model == SHADING_RIM) {
        result += lobes.rim;
    }
    return result;
}
