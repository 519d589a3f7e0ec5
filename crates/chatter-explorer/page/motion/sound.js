/** The sound of impacts: a short knock each, as loud as the impact is fast. */

/** So many knocks at most in one look ahead: more are one noise. */
const MOST = 40;

export class Sound {
    constructor() {
        /** @type {AudioContext | null} */
        this.context = null;
        /** @type {AudioBuffer | null} */
        this.knock = null;
    }

    /** Switches it on; browsers allow that only after a click. */
    on() {
        this.context ??= new AudioContext();
        void this.context.resume();
        if (this.knock) return;
        const { context } = this;
        const length = Math.round(context.sampleRate * 0.06);
        this.knock = context.createBuffer(1, length, context.sampleRate);
        const wave = this.knock.getChannelData(0);
        for (let k = 0; k < length; k += 1) {
            const time = k / context.sampleRate;
            wave[k] = Math.exp(-time * 90) * (0.8 * Math.sin(2 * Math.PI * 1150 * time) + 0.5 * Math.sin(2 * Math.PI * 2710 * time) + 0.3 * (Math.random() * 2 - 1));
        }
    }

    off() {
        void this.context?.suspend();
    }

    /**
     * Impacts of the next moment.
     * @param {{ delay: number, strength: number }[]} impacts seconds from now, and strength of one at most
     */
    play(impacts) {
        const { context, knock } = this;
        if (!context || !knock || context.state !== "running") return;
        const loudest = [...impacts].sort((one, other) => other.strength - one.strength).slice(0, MOST);
        for (const { delay, strength } of loudest) {
            const source = context.createBufferSource();
            const gain = context.createGain();
            source.buffer = knock;
            gain.gain.value = 0.5 * Math.sqrt(Math.min(1, strength));
            source.connect(gain).connect(context.destination);
            source.start(context.currentTime + Math.max(0, delay));
        }
    }
}
