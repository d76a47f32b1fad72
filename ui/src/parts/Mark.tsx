/** The mark of Kinemark: a path of a marker. */
export const Mark = (): React.JSX.Element => (
  <svg viewBox="0 0 32 32" width="22" height="22" aria-hidden="true">
    <rect width="32" height="32" rx="7" fill="#0b2a3f" />
    <path d="M6 25C12 25 11 9 17 9s5 13 10 9" fill="none" stroke="#63b8f0" strokeWidth="2.6" strokeLinecap="round" />
    <circle cx="17" cy="9" r="3.4" fill="#e69f00" />
    <circle cx="6" cy="25" r="2.6" fill="#fff" />
  </svg>
);
