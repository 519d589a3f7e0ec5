/** Where to begin with a model: what its orbits are looked at over, and for how long a motion is followed. */

/** @typedef {import("./state.js").Checked} Checked */

/** Of shipped models, where they show most. */
/** @type {Record<string, object>} */
const KNOWN = {
    pressure_relief_valve: { diagram: { over: "q", from: 0.0195, to: 0.0235, observe: "y2" }, to: 12 },
    impact_oscillator: { diagram: { over: "omega", from: 2.5, to: 3, observe: "v" }, to: 40, set: { omega: "2.8" } },
    impact_oscillator_two_sided: { diagram: { over: "omega", from: 0.4, to: 1.4, observe: "v", sampling: "section:stroboscopic" }, to: 60 },
    linear_impacting_system: { diagram: { over: "beta", from: 10, to: 60, observe: "x2" }, to: 20 },
    bouncing_ball_on_table: { diagram: { over: "Gamma", from: 1, to: 6, observe: "v" }, to: 2 },
    bouncing_ball: { diagram: { over: "r", from: 0.2, to: 0.9, observe: "y", transient: 0, keep: 12 }, to: 2 },
    cam_follower: { diagram: { over: "speed", from: 400, to: 800, observe: "v" }, to: 1 },
    dwell_cam: { diagram: { over: "omega", from: 1, to: 5, observe: "y" }, to: 20 },
    soft_stop: { diagram: { over: "omega", from: 0.4, to: 2, observe: "x" }, to: 60 },
    preloaded_stop: { diagram: { over: "omega", from: 0.5, to: 1.5, observe: "x" }, to: 80 },
    gear_backlash: { diagram: { over: "omega", from: 0.3, to: 1.2, observe: "x" }, to: 120 },
    percussive_drill: { diagram: { over: "shake", from: 0.2, to: 1.2, observe: "x - p" }, to: 120 },
    vibro_impact_capsule: { diagram: { over: "omega", from: 0.8, to: 1.6, observe: "x1 - x2" }, to: 80 },
    rocking_block: { diagram: { over: "load", from: 0.1, to: 0.4, observe: "theta" }, to: 40 },
    rotor_in_clearance: { diagram: { over: "speed", from: 1, to: 3, observe: "x" }, to: 60 },
    chua_circuit: { diagram: { over: "alpha", from: 8, to: 10, observe: "y" }, to: 60 },
    mass_on_belt: { diagram: { over: "belt", from: 0.05, to: 1.5, observe: "x" }, to: 60 },
    relay_feedback: { diagram: { over: "gain", from: 2, to: 12, observe: "y" }, to: 40 },
    forced_coulomb_oscillator: { diagram: { over: "omega", from: 0.2, to: 1.2, observe: "x" }, to: 80 },
    newtons_cradle: { diagram: { over: "r", from: 0.5, to: 0.99, observe: "x1", transient: 20, keep: 20 }, to: 30 },
};

/**
 * A view of any model.
 * @param {string} name
 * @param {Checked | null} checked
 * @returns {any}
 */
export function start_of(name, checked) {
    const parameter = checked?.parameters.find((one) => !one.unused && !one.depends) ?? checked?.parameters[0];
    const value = parameter?.value ?? 1;
    const [low, high] = value === 0 ? [-1, 1] : [value - 0.25 * Math.abs(value), value + 0.25 * Math.abs(value)];
    const states = (checked?.states ?? []).filter((state) => !state.time);
    const sections = checked?.sections ?? [];
    const contacts = checked?.contacts ?? [];
    const sampling = sections.length > 0 ? `section:${sections[0].name}` : contacts.length > 0 ? "at:impact" : "period:1";
    const observe = states[Math.min(1, states.length - 1)]?.name ?? "";
    const portrait = states.length > 1 ? [states[0].name, states[1].name] : ["time", states[0]?.name ?? ""];
    const known = /** @type {any} */ (KNOWN[name] ?? {});
    const over = known.diagram?.over;
    const fits = over === undefined || (checked?.parameters ?? []).some((one) => one.name === over);
    const own = fits ? known : {};
    return {
        set: { ...own.set },
        initial: {},
        picked: null,
        through: null,
        from: 0,
        to: own.to ?? 50,
        portrait,
        returned: observe,
        diagram: {
            over: parameter?.name ?? "", from: low, to: high, y: null, second: "", second_from: 0, second_to: 1, observe, sampling,
            start: "fresh", bounds: "", columns: 512, transient: 300, keep: 200, exponent: false, slope: 0, ...own.diagram,
        },
    };
}
