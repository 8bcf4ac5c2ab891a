! What user routines of Abaqus call beside their own code: XIT and STDB_ABQERR, invariants, principal values and
! directions, turned tensors. Tensors have the components 11, 22, 33, 12, 13, 23, as many as NDI + NSHR say.
!
! XIT, STOP and the like end the run of the routine, not the process: they jump back to where the routine was called,
! which then has no stress for this step. STOP comes here as the linker wraps what the compiler makes of it.

module geoswarm_umat
  use, intrinsic :: iso_c_binding, only: c_ptr, c_null_ptr, c_associated, c_int, c_size_t, c_char, c_int8_t
  implicit none
  private
  public :: way_back, leave, leave_with, leave_with_code, full_tensor, eigen

  type(c_ptr), bind(C, name="geoswarm_umat_return") :: way_back = c_null_ptr

  interface
    subroutine c_longjmp(environment, number) bind(C, name="longjmp")
      import :: c_ptr, c_int
      type(c_ptr), value :: environment
      integer(c_int), value :: number
    end subroutine c_longjmp
    subroutine c_abort() bind(C, name="abort")
    end subroutine c_abort
  end interface

contains

  subroutine leave(words)
    character(*), intent(in) :: words
    write (6, '(a)') trim(words)
    flush (6)
    if (c_associated(way_back)) call c_longjmp(way_back, 1_c_int)
    call c_abort()
  end subroutine leave

  ! Leave with the first 200 characters of what STOP was given.
  subroutine leave_with(beginning, text, length)
    character(*), intent(in) :: beginning
    character(kind=c_char), intent(in) :: text(*)
    integer(c_size_t), intent(in) :: length
    character(200) :: words
    integer(c_size_t) :: i
    words = ""
    do i = 1, min(length, 200_c_size_t)
      words(i:i) = text(i)
    end do
    call leave(beginning//trim(words))
  end subroutine leave_with

  ! Leave with the number that STOP or EXIT was given.
  subroutine leave_with_code(beginning, code)
    character(*), intent(in) :: beginning
    integer(c_int), intent(in) :: code
    character(40) :: words
    write (words, '(i0)') code
    call leave(beginning//trim(words))
  end subroutine leave_with_code

  ! The symmetric matrix of a stress (kind 1) or of a strain with engineering shear (kind 2).
  subroutine full_tensor(s, kind, ndi, nshr, a)
    integer, intent(in) :: kind, ndi, nshr
    real(8), intent(in) :: s(*)
    real(8), intent(out) :: a(3, 3)
    integer :: i
    integer, parameter :: row(3) = [1, 1, 2], column(3) = [2, 3, 3]
    real(8) :: share
    share = merge(0.5d0, 1.0d0, kind == 2)
    a = 0.0d0
    do i = 1, ndi
      a(i, i) = s(i)
    end do
    do i = 1, nshr
      a(row(i), column(i)) = share*s(ndi + i)
      a(column(i), row(i)) = a(row(i), column(i))
    end do
  end subroutine full_tensor

  ! Eigenvalues of a symmetric matrix and its eigenvectors as rows of v, by the rotations of Jacobi.
  subroutine eigen(given, values, v)
    real(8), intent(in) :: given(3, 3)
    real(8), intent(out) :: values(3), v(3, 3)
    real(8) :: a(3, 3), angle, c, s, turn(3, 3), off
    integer :: sweep, p, q, i
    a = given
    v = 0.0d0
    do i = 1, 3
      v(i, i) = 1.0d0
    end do
    do sweep = 1, 50
      off = a(1, 2)**2 + a(1, 3)**2 + a(2, 3)**2
      if (off <= 1.0d-32*(a(1, 1)**2 + a(2, 2)**2 + a(3, 3)**2) .or. off == 0.0d0) exit
      do p = 1, 2
        do q = p + 1, 3
          if (a(p, q) == 0.0d0) cycle
          angle = 0.5d0*atan2(2.0d0*a(p, q), a(q, q) - a(p, p))
          c = cos(angle)
          s = sin(angle)
          turn = 0.0d0
          do i = 1, 3
            turn(i, i) = 1.0d0
          end do
          turn(p, p) = c
          turn(q, q) = c
          turn(p, q) = -s
          turn(q, p) = s
          a = matmul(turn, matmul(a, transpose(turn)))
          v = matmul(turn, v)
        end do
      end do
    end do
    do i = 1, 3
      values(i) = a(i, i)
    end do
  end subroutine eigen

end module geoswarm_umat

subroutine xit()
  use geoswarm_umat, only: leave
  implicit none
  call leave("the routine called XIT")
end subroutine xit

! LOP 1: a message, -1: a warning, -2: an error after which it goes on, -3: an error after which it ends. %I, %R and %S
! in the text stand for the next of the integers, numbers and texts.
subroutine stdb_abqerr(lop, text, intv, realv, charv)
  use geoswarm_umat, only: leave
  implicit none
  integer :: lop, intv(*), i, n(3), length
  real(8) :: realv(*)
  character(*) :: text
  character(8) :: charv(*)
  character(40) :: one
  character(1000) :: line
  n = 0
  length = 0
  line = ""
  i = 1
  do while (i <= len_trim(text))
    one = text(i:i)
    if (text(i:i) == "%" .and. i < len(text)) then
      select case (text(i + 1:i + 1))
      case ("I", "i")
        n(1) = n(1) + 1
        write (one, '(i0)') intv(n(1))
        i = i + 1
      case ("R", "r")
        n(2) = n(2) + 1
        write (one, '(es14.6)') realv(n(2))
        one = adjustl(one)
        i = i + 1
      case ("S", "s")
        n(3) = n(3) + 1
        one = charv(n(3))
        i = i + 1
      end select
    end if
    line(length + 1:) = one
    length = length + max(1, len_trim(one))
    i = i + 1
    if (length > 950) exit
  end do
  if (lop == -3) call leave("STDB_ABQERR ended the routine: "//trim(line))
  write (6, '(a)') trim(line)
end subroutine stdb_abqerr

! Mean of the normal components, and equivalent stress of von Mises.
subroutine sinv(stress, sinv1, sinv2, ndi, nshr)
  use geoswarm_umat, only: full_tensor
  implicit none
  integer :: ndi, nshr, i
  real(8) :: stress(*), sinv1, sinv2, a(3, 3)
  call full_tensor(stress, 1, ndi, nshr, a)
  sinv1 = (a(1, 1) + a(2, 2) + a(3, 3))/3.0d0
  do i = 1, 3
    a(i, i) = a(i, i) - sinv1
  end do
  sinv2 = sqrt(1.5d0*sum(a*a))
end subroutine sinv

! Principal values.
subroutine sprinc(s, ps, lstr, ndi, nshr)
  use geoswarm_umat, only: full_tensor, eigen
  implicit none
  integer :: lstr, ndi, nshr
  real(8) :: s(*), ps(3), a(3, 3), v(3, 3)
  call full_tensor(s, lstr, ndi, nshr, a)
  call eigen(a, ps, v)
end subroutine sprinc

! Principal values, and their directions as rows of AN.
subroutine sprind(s, ps, an, lstr, ndi, nshr)
  use geoswarm_umat, only: full_tensor, eigen
  implicit none
  integer :: lstr, ndi, nshr
  real(8) :: s(*), ps(3), an(3, 3), a(3, 3)
  call full_tensor(s, lstr, ndi, nshr, a)
  call eigen(a, ps, an)
end subroutine sprind

! A tensor turned by R: R S R^T.
subroutine rotsig(s, r, sprime, lstr, ndi, nshr)
  use geoswarm_umat, only: full_tensor
  implicit none
  integer :: lstr, ndi, nshr, i
  integer, parameter :: row(3) = [1, 1, 2], column(3) = [2, 3, 3]
  real(8) :: s(*), r(3, 3), sprime(*), a(3, 3)
  call full_tensor(s, lstr, ndi, nshr, a)
  a = matmul(r, matmul(a, transpose(r)))
  do i = 1, ndi
    sprime(i) = a(i, i)
  end do
  do i = 1, nshr
    sprime(ndi + i) = merge(2.0d0, 1.0d0, lstr == 2)*a(row(i), column(i))
  end do
end subroutine rotsig

! What STOP, ERROR STOP, EXIT, ABORT and failed checks of the compiler become: see the linker's option --wrap.

subroutine stop_string(text, length, quiet) bind(C, name="__wrap__gfortran_stop_string")
  use, intrinsic :: iso_c_binding, only: c_size_t, c_char, c_int8_t
  use geoswarm_umat, only: leave_with
  implicit none
  character(kind=c_char), intent(in) :: text(*)
  integer(c_size_t), value :: length
  integer(c_int8_t), value :: quiet
  call leave_with("the routine stopped: STOP ", text, length)
end subroutine stop_string

subroutine stop_numeric(code, quiet) bind(C, name="__wrap__gfortran_stop_numeric")
  use, intrinsic :: iso_c_binding, only: c_int, c_int8_t
  use geoswarm_umat, only: leave_with_code
  implicit none
  integer(c_int), value :: code
  integer(c_int8_t), value :: quiet
  call leave_with_code("the routine stopped: STOP ", code)
end subroutine stop_numeric

subroutine error_stop_string(text, length, quiet) bind(C, name="__wrap__gfortran_error_stop_string")
  use, intrinsic :: iso_c_binding, only: c_size_t, c_char, c_int8_t
  use geoswarm_umat, only: leave_with
  implicit none
  character(kind=c_char), intent(in) :: text(*)
  integer(c_size_t), value :: length
  integer(c_int8_t), value :: quiet
  call leave_with("the routine stopped: ERROR STOP ", text, length)
end subroutine error_stop_string

subroutine error_stop_numeric(code, quiet) bind(C, name="__wrap__gfortran_error_stop_numeric")
  use, intrinsic :: iso_c_binding, only: c_int, c_int8_t
  use geoswarm_umat, only: leave_with_code
  implicit none
  integer(c_int), value :: code
  integer(c_int8_t), value :: quiet
  call leave_with_code("the routine stopped: ERROR STOP ", code)
end subroutine error_stop_numeric

subroutine call_exit(code) bind(C, name="__wrap__gfortran_exit_i4")
  use, intrinsic :: iso_c_binding, only: c_int
  use geoswarm_umat, only: leave_with_code
  implicit none
  integer(c_int), intent(in) :: code
  call leave_with_code("the routine called EXIT ", code)
end subroutine call_exit

subroutine call_abort() bind(C, name="__wrap__gfortran_abort")
  use geoswarm_umat, only: leave
  implicit none
  call leave("the routine called ABORT")
end subroutine call_abort

subroutine runtime_error_at(place, form) bind(C, name="__wrap__gfortran_runtime_error_at")
  use, intrinsic :: iso_c_binding, only: c_char, c_null_char
  use geoswarm_umat, only: leave
  implicit none
  character(kind=c_char), intent(in) :: place(*), form(*)
  character(400) :: words
  integer :: i, length
  words = ""
  length = 0
  do i = 1, 200
    if (place(i) == c_null_char) exit
    length = length + 1
    words(length:length) = place(i)
  end do
  length = length + 2
  do i = 1, 190
    if (form(i) == c_null_char) exit
    words(length + i:length + i) = form(i)
  end do
  call leave("the routine failed a check of its compiler. "//trim(words))
end subroutine runtime_error_at
