// What the lights see of a point.
struct Surface {
    vec3 position;
    vec3 normal;
    vec3 base_color;
    float alpha;
    float metallic;
    float roughness;
    float occlusion;
    vec3 emissive;
    bool unlit;
    // Of the shading model: which, its second colour and its exponent.
    uint model;
    vec3 model_color;
    float model_exponent;
};
