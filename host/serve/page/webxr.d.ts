// The part of WebXR that the page uses (https://www.w3.org/TR/webxr). TypeScript has no types of it.

declare class XRRigidTransform {
  constructor(position?: {x?: number, y?: number, z?: number});
  readonly position: DOMPointReadOnly;
  readonly orientation: DOMPointReadOnly;
  readonly matrix: Float32Array;
  readonly inverse: XRRigidTransform;
}
interface XRSpace extends EventTarget {}
interface XRReferenceSpace extends XRSpace {
  getOffsetReferenceSpace(origin: XRRigidTransform): XRReferenceSpace;
}
interface XRPose { readonly transform: XRRigidTransform; }
interface XRView {
  readonly eye: 'left' | 'right' | 'none';
  readonly projectionMatrix: Float32Array;
  readonly transform: XRRigidTransform;
}
interface XRViewerPose extends XRPose { readonly views: readonly XRView[]; }
interface XRInputSource {
  readonly handedness: 'left' | 'right' | 'none';
  readonly targetRaySpace: XRSpace;
  readonly gripSpace?: XRSpace;
  readonly gamepad?: Gamepad | null;
}
interface XRFrame {
  readonly session: XRSession;
  getViewerPose(space: XRReferenceSpace): XRViewerPose | null | undefined;
  getPose(space: XRSpace, base: XRSpace): XRPose | null | undefined;
}
interface XRSession extends EventTarget {
  readonly visibilityState: 'visible' | 'visible-blurred' | 'hidden';
  readonly inputSources: Iterable<XRInputSource>;
  requestAnimationFrame(act: (time: number, frame: XRFrame) => void): number;
  requestReferenceSpace(type: string): Promise<XRReferenceSpace>;
  updateRenderState(state: {baseLayer?: XRWebGLLayer, depthNear?: number, depthFar?: number}): void;
  end(): Promise<void>;
}
interface XRInputSourceEvent extends Event { readonly inputSource: XRInputSource; }
interface XRSystem extends EventTarget {
  isSessionSupported(mode: string): Promise<boolean>;
  requestSession(mode: string, init?: {requiredFeatures?: string[], optionalFeatures?: string[]}):
    Promise<XRSession>;
}
interface WebGL2RenderingContext { makeXRCompatible(): Promise<void>; }
interface Navigator { readonly xr?: XRSystem; }
declare class XRWebGLLayer {
  constructor(session: XRSession, gl: WebGL2RenderingContext, init?: {antialias?: boolean});
  readonly framebuffer: WebGLFramebuffer | null;
  readonly framebufferWidth: number;
  readonly framebufferHeight: number;
  getViewport(view: XRView):
    {readonly x: number, readonly y: number, readonly width: number, readonly height: number};
}
